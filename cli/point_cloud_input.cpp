#include "arbox/cli/point_cloud_input.h"

#include <iostream>
#include <iterator>

namespace arbox::cli {

io::PointCloudFile read_point_cloud_input(const std::string& path, const io::ReadOptions& options) {
  if (path != "-") return io::read_point_cloud(path, options);
  const std::string content(std::istreambuf_iterator<char>(std::cin), {});
  return io::parse_point_cloud(content, "standard input", options);
}

}  // namespace arbox::cli
