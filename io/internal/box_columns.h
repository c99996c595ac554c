#pragma once

#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "arbox/io/box_table.h"
#include "arbox/io/internal/text.h"

/// \file
/// Which column of a box table holds what.

namespace arbox::io::internal {

/// Names of the columns in the order of the file.
using BoxColumns = std::vector<std::string_view>;

inline constexpr std::array<std::string_view, 6> kBoxColumns = {"x", "y", "z", "l", "w", "h"};
inline constexpr std::array<std::string_view, 4> kQuaternionColumns = {"qw", "qx", "qy", "qz"};

/// Fields between commas, else semicolons, else runs of white space; quotation marks protect
/// separators.
std::vector<std::string_view> split_fields(std::string_view line);

/// The field without its quotation marks, doubled ones inside made single.
std::string unquoted(std::string_view field);

/// True if no field is a number.
bool is_header(const std::vector<std::string_view>& fields);

/// The columns that a header names; refuses unknown, doubled and missing names. The names point
/// into the text of `fields`.
BoxColumns header_columns(const std::vector<std::string_view>& fields, const TextPlace& place);

/// The columns of a first row without a header; refuses what fits nothing or two things.
BoxColumns guessed_columns(const std::vector<std::string_view>& fields,
                           const BoxTableOptions& options, const TextPlace& place);

}  // namespace arbox::io::internal
