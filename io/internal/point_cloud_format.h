#pragma once

#include <string>

#include "arbox/io/point_cloud_file.h"

namespace arbox::io::internal {

/// The format of that name_of(). Throws InvalidArgument.
PointCloudFormat format_named(const std::string& word);

}  // namespace arbox::io::internal
