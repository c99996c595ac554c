#pragma once

#include <cstdlib>

#include "arbox/io/point_cloud_file.h"
#include "fuzz_input.h"

namespace arbox::fuzz {

/// Parses the input as a cloud of one format; a result must be consistent, and its points must
/// come back the same through the binary PCD writer.
inline int run_point_cloud(const std::uint8_t* data, std::size_t size, const char* format,
                           const std::vector<std::string>& channels = {}) {
  return run(data, size, [&](std::string_view bytes) {
    const auto file =
        io::parse_point_cloud(bytes, "fuzz", {.channels = channels, .format = format});
    const auto& points = file.points;
    if (points.values.size() % points.columns() != 0) std::abort();
    if (points.size() + file.dropped != file.points_in_file) std::abort();
    if (points.size() > 64 * (bytes.size() + 1)) return;
    const geometry::PointCloud plain{
        .channels = {},
        .values = std::vector<float>(
            points.values.begin(),
            points.values.begin() +
                3 * static_cast<std::ptrdiff_t>(std::min<std::size_t>(1, points.size())))};
    const auto encoded = io::encode_point_cloud(plain.view(), io::PointCloudFormat::kPcd);
    if (io::parse_point_cloud(encoded, "again").points.values != plain.values) std::abort();
  });
}

}  // namespace arbox::fuzz
