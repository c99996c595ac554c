#pragma once

#include <string>

#include "arbox/io/point_cloud_file.h"

namespace arbox::cli {

/// Reads a point cloud from a file, or from standard input if the path is "-".
io::PointCloudFile read_point_cloud_input(const std::string& path, const io::ReadOptions& options);

}  // namespace arbox::cli
