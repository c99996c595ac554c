#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "arbox/io/number_type.h"
#include "arbox/io/point_cloud_file.h"

namespace arbox::io::internal {

/// One field of a file that is written: a number type and where the values come from.
struct OutputField {
  std::string name;
  NumberType type = NumberType::kFloat32;
  /// Numbers of the cloud: 0 to 2 are x, y, z, 3 + i the i-th selected channel.
  std::size_t source = 0;
};

/// A view and the channels of it that are written.
struct Output {
  const geometry::PointCloudView& points;
  std::vector<const geometry::Channel*> channels;

  /// Coordinate or channel of point i, as OutputField::source counts; colours in 0..1.
  float value(std::size_t source, std::size_t i) const;
  /// The colour of point i as a byte.
  std::uint8_t color_byte(std::size_t source, std::size_t i) const;
  /// Where the channel of that name is, as OutputField::source counts; 0 if it is not selected.
  std::size_t find(std::string_view name) const;
  /// The type that holds the channel: uint16 for a ring and uint32 for a label of whole numbers.
  NumberType type_of(std::size_t source) const;
};

std::string encode_pcd(const Output& output, const std::string& encoding);
std::string encode_ply(const Output& output, const std::string& encoding);
std::string encode_csv(const Output& output);

/// Appends `value` as the bytes of a number of that type (float32, uint8, uint16 or uint32).
void append_number_bytes(std::string& bytes, NumberType type, float value);

/// Appends the shortest digits that read back the same.
void append_shortest(std::string& text, NumberType type, float value);

}  // namespace arbox::io::internal
