#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "arbox/geometry/box.h"
#include "arbox/geometry/detection.h"

/// \file
/// Boxes as delimited text, one a row (docs/formats.md, "CSV boxes"):
///
///     x,y,z,l,w,h,yaw                 a box whose rotation is about z
///     x,y,z,l,w,h,qw,qx,qy,qz         a box of any rotation
///
/// Metres and radians, full sizes. Fields are separated by commas, semicolons, tabs or spaces. One
/// header line may name the columns; then they may come in any order, and the columns `object`
/// (whole number that groups rows), `score` and `class` may be among them.

namespace arbox::io {

/// The rows of a file. Each of `objects`, `scores`, `classes` is empty or has one entry a box.
struct BoxTable {
  std::vector<geometry::Box> boxes;
  /// Number of the object that the box is a sample of.
  std::vector<std::int64_t> objects;
  /// Finite numbers; nothing is said about their range.
  std::vector<double> scores;
  std::vector<std::string> classes;
};

/// Extra columns that a file without a header may have; a header names them itself.
struct BoxTableOptions {
  /// A first column `object`.
  bool object = false;
  /// A column `score` after the box.
  bool score = false;
  /// A column `class` after the box (any text that is not a number).
  bool class_name = false;
};

/// Reads a file. A file without rows, with or without a header, gives an empty table.
///
/// Quaternions within 1e-3 of unit norm are normalised. Throws FormatError with file, line, what
/// was expected and what came for wrong counts of fields, unknown, missing or doubled column names,
/// fields that are not finite numbers, sizes that are not above zero, other quaternions, and a file
/// without a header whose columns could mean two things under `options`. Throws IoError for a
/// missing file or a directory. Linear in the file's size.
BoxTable read_box_table(const std::filesystem::path& path, const BoxTableOptions& options = {});

/// read_box_table of a text in memory; `source` is its name in messages.
BoxTable parse_box_table(std::string_view text, std::string_view source,
                         const BoxTableOptions& options = {});

/// The table as comma-separated text with a header and 17 significant digits, so that centre, size
/// and quaternion read back as the same doubles. Seven columns a box if every rotation is about z,
/// ten otherwise. Throws InvalidArgument for invalid boxes or columns of unequal length.
std::string format_box_table(const BoxTable& table);

/// Writes format_box_table() to a file, whole or not at all. Throws IoError.
void write_box_table(const std::filesystem::path& path, const BoxTable& table);

/// The boxes of detections with the columns `class` and `score`.
BoxTable to_box_table(std::span<const geometry::Detection> detections);

}  // namespace arbox::io
