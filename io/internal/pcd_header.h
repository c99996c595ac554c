#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "arbox/io/internal/text.h"
#include "arbox/io/number_type.h"

namespace arbox::io::internal {

struct PcdField {
  std::string name;
  NumberType type = NumberType::kFloat32;
  std::size_t count = 1;
  /// Bytes before this field in a point.
  std::size_t offset = 0;
};

struct PcdHeader {
  std::vector<PcdField> fields;
  /// Bytes and numbers of one point.
  std::size_t stride = 0, numbers = 0;
  std::size_t width = 0, height = 1, points = 0;
  std::array<double, 7> viewpoint{0, 0, 0, 1, 0, 0, 0};
  /// "ascii", "binary" or "binary_compressed".
  std::string data;
};

/// Reads up to and with the line DATA; `lines` stands there afterwards. Throws FormatError.
PcdHeader parse_pcd_header(LineReader& lines);

}  // namespace arbox::io::internal
