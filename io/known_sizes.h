#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <string_view>

#include "arbox/geometry/known_size.h"

/// \file
/// The sizes that objects of a class may have, as delimited text, one a row (docs/formats.md,
/// "Known sizes"):
///
///     class,l,w,h,name
///     Car,4.28,1.79,1.49,Golf
///     Car,4.90,1.87,1.45,
///
/// Fields are separated as in io/box_table.h. A first line without a number names the columns,
/// which may then come in any order; without one they are class, l, w, h and, if it is there, name.

namespace arbox::io {

/// Metres; what is beyond is taken for another unit.
inline constexpr double kLeastKnownExtent = 0.01, kMostKnownExtent = 100.0;

struct KnownSizeTable {
  geometry::KnownSizes sizes;
  /// The line where each class stands first, from 1, for messages.
  std::map<std::string, std::size_t> lines;
};

/// Throws FormatError with file, line, what was expected and what came for a text without a row,
/// wrong counts of fields, unknown, doubled or missing names of columns, classes without a name,
/// and extents that are not numbers from kLeastKnownExtent to kMostKnownExtent.
KnownSizeTable parse_known_sizes(std::string_view text, std::string_view source);

/// parse_known_sizes of a file. Throws IoError for a missing file or a directory.
KnownSizeTable read_known_sizes(const std::filesystem::path& path);

}  // namespace arbox::io
