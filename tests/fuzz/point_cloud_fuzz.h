#pragma once

#include <cstdlib>
#include <string>
#include <vector>

#include "arbox/io/point_cloud_file.h"
#include "fuzz_input.h"

namespace arbox::fuzz {

/// Parses the input as a cloud of one format. What is read must be consistent with its report, and
/// its first coordinates must come back the same through the writer of binary PCD.
inline int run_point_cloud(const std::uint8_t* data, std::size_t size, const char* format) {
  return run(data, size, [&](std::string_view bytes) {
    const auto file = io::parse_point_cloud(bytes, "fuzz", {.format = format});
    const geometry::PointCloud& points = file.points;
    if (points.values.size() % points.columns() != 0) std::abort();
    if (points.size() + file.dropped != file.points_in_file) std::abort();
    if (points.view().empty()) return;
    const geometry::PointCloud first{.channels = {},
                                     .values = {points.values.begin(), points.values.begin() + 3}};
    const auto encoded = io::encode_point_cloud(first.view(), io::PointCloudFormat::kPcd);
    if (io::parse_point_cloud(encoded, "again").points.values != first.values) std::abort();
  });
}

}  // namespace arbox::fuzz
