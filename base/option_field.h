#pragma once

#include <limits>
#include <string_view>
#include <vector>

namespace arbox {

/// What an options struct says of one of its fields.
///
/// Every configurable struct has one static member template
///
///     template <class Visitor>
///     static void describe(Visitor& visitor) {
///       visitor.field("voxel_size", &Options::voxel_size,
///                     {.help = "Edge of a voxel", .unit = "m", .low = 0.001, .high = 10});
///       visitor.group("nms", &Options::nms, "How overlapping detections are merged");
///     }
///
/// that names each field once. Reading YAML, command-line flags, `arbox config`, documentation and
/// validation all come from it (base/options.h). Fields may be bool, int, std::int64_t,
/// std::uint64_t, float, double, std::string, an enum class (its values 0, 1, ... in the order of
/// `choices`), std::optional or std::vector of these except enums, or std::array of 2, 3, 4 or 6 of
/// these; `group` takes a nested described struct.
struct OptionField {
  std::string_view help;
  /// SI unit or a word such as "points"; empty for none.
  std::string_view unit = "";
  /// Allowed range of a number (of every element of a list), both ends allowed. NaN never is.
  double low = -std::numeric_limits<double>::infinity();
  double high = std::numeric_limits<double>::infinity();
  /// Allowed words of a string; empty means any. The names of an enum's values.
  std::vector<std::string_view> choices = {};
};

}  // namespace arbox
