#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "arbox/io/internal/text.h"
#include "arbox/io/number_type.h"

namespace arbox::io::internal {

enum class PlyEncoding { kAscii, kBinaryLittleEndian, kBinaryBigEndian };

struct PlyProperty {
  std::string name;
  /// The number, or a list's numbers.
  NumberType type = NumberType::kFloat32;
  /// The type of a list's length; empty for a single number.
  std::optional<NumberType> length_type;
};

struct PlyElement {
  std::string name;
  std::size_t count = 0;
  std::vector<PlyProperty> properties;

  bool has_lists() const;
  /// Bytes of its single numbers.
  std::size_t scalar_bytes() const;
};

struct PlyHeader {
  PlyEncoding encoding = PlyEncoding::kAscii;
  std::vector<PlyElement> elements;
};

/// Reads up to and with end_header; `lines` stands there afterwards. Throws FormatError.
PlyHeader parse_ply_header(LineReader& lines);

}  // namespace arbox::io::internal
