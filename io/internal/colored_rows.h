#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "arbox/geometry/point_cloud_view.h"
#include "arbox/io/npy.h"

namespace arbox::io::internal {

/// Rows x y z r g b as a cloud with channels r g b in 0..1: colours are divided by 255 if one of
/// them is above 1 (files of ScanNet hold 0..255, those of SUN RGB-D 0..1). Rows with a coordinate
/// that is not finite are left out; `kept`, if given, gets the rows that stay. Throws FormatError
/// unless the array has two dimensions and 3 or 6 columns.
geometry::PointCloud colored_cloud(const NpyArray& rows, const std::string& name,
                                   std::vector<std::int32_t>* kept = nullptr);
geometry::PointCloud colored_cloud(std::vector<float> values, std::size_t columns,
                                   std::vector<std::int32_t>* kept = nullptr);

/// The cloud as rows x y z r g b with colours times `scale`, 0 where it has none.
std::vector<float> colored_rows(const geometry::PointCloud& cloud, float scale);

}  // namespace arbox::io::internal
