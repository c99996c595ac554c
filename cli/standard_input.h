#pragma once

#include <string>

#include "arbox/io/box_table.h"
#include "arbox/io/point_cloud_file.h"

/// \file
/// Inputs of commands that are files, or standard input if the path is "-".

namespace arbox::cli {

/// What messages and results call standard input.
inline constexpr char kStandardInput[] = "standard input";

/// All that comes on standard input. Throws IoError.
std::string read_standard_input();

/// io::read_point_cloud, or parse_point_cloud of standard input.
io::PointCloudFile read_point_cloud_input(const std::string& path, const io::ReadOptions& options);

/// io::read_box_table, or parse_box_table of standard input.
io::BoxTable read_box_table_input(const std::string& path, const io::BoxTableOptions& options = {});

}  // namespace arbox::cli
