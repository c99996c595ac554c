#include "arbox/cli/standard_input.h"

#include <iostream>
#include <iterator>

#include "arbox/base/error.h"

namespace arbox::cli {

std::string read_standard_input() {
  std::string content(std::istreambuf_iterator<char>(std::cin), {});
  if (std::cin.bad()) throw IoError("standard input: cannot be read");
  return content;
}

io::PointCloudFile read_point_cloud_input(const std::string& path, const io::ReadOptions& options) {
  if (path != "-") return io::read_point_cloud(path, options);
  return io::parse_point_cloud(read_standard_input(), kStandardInput, options);
}

io::BoxTable read_box_table_input(const std::string& path, const io::BoxTableOptions& options) {
  if (path != "-") return io::read_box_table(path, options);
  return io::parse_box_table(read_standard_input(), kStandardInput, options);
}

}  // namespace arbox::cli
