#include <algorithm>
#include <limits>

#include "arbox/io/internal/columns.h"
#include "arbox/io/internal/parse.h"
#include "arbox/io/internal/text.h"
#include "arbox/io/npz.h"

// Point clouds in NumPy arrays: one row a point, or an image of rows.

namespace arbox::io::internal {
namespace {

bool is_cloud_shape(const std::vector<std::size_t>& shape) {
  return (shape.size() == 2 || shape.size() == 3) && shape.back() >= 3 &&
         shape.back() <= kMostColumns;
}

std::string choose_array(const NpzFile& archive, const std::string& name,
                         const ReadOptions& options) {
  const auto& names = archive.names();
  if (!options.array.empty()) return options.array;
  if (names.size() == 1) return names.front();
  for (const char* usual : {"points", "pc", "point_cloud", "xyz"}) {
    if (std::find(names.begin(), names.end(), usual) != names.end()) return usual;
  }
  if (names.empty()) fail(name, "expected an archive of .npy arrays, got none");
  fail(name, "which array holds the points is not certain: " + listed(names, " or ") +
                 "; say which with the option array");
}

}  // namespace

PointCloudFile parse_npy_cloud(std::string_view content, const std::string& name,
                               const ReadOptions& options) {
  const NpyHeader header = parse_npy_header(content, name);
  const auto& shape = header.shape;
  if (!is_cloud_shape(shape)) {
    std::string text;
    for (const std::size_t size : shape) {
      text += (text.empty() ? "" : ", ") + std::to_string(size);
    }
    fail(name, "expected points as an array of shape (N, C) or (H, W, C) with 3 <= C <= " +
                   std::to_string(kMostColumns) + ", got shape (" + text + ")");
  }
  PointCloudFile file{.format = PointCloudFormat::kNpy,
                      .encoding = std::string(name_of(header.type))};
  const std::size_t width = shape.back();
  const std::size_t rows = header.count() / width;
  const std::size_t bytes = size_of(header.type);
  file.points_in_file = rows;
  file.width = shape[shape.size() - 2];
  file.height = shape.size() == 3 ? shape[0] : 1;
  file.unused_bytes = content.size() - header.data_offset - header.count() * bytes;
  if (header.fortran_order && shape.size() == 3 && rows > 0) {
    fail(name, "expected C order for points of shape (H, W, C), got Fortran order");
  }
  std::vector<Column> columns(width);
  for (std::size_t c = 0; c < width; ++c) {
    columns[c].type = header.type;
    columns[c].big_endian = header.big_endian;
    columns[c].stride = header.fortran_order ? bytes : width * bytes;
    columns[c].data = reinterpret_cast<const std::byte*>(content.data()) + header.data_offset;
    if (rows > 0) columns[c].data += header.fortran_order ? c * rows * bytes : c * bytes;
  }
  const auto names = column_names(width, has_negative_tail(columns, rows), name, options);
  for (std::size_t c = 0; c < width; ++c) columns[c].name = names[c];
  return assemble(std::move(columns), std::move(file), name, options);
}

PointCloudFile parse_npz_cloud(std::string_view content, const std::string& name,
                               const ReadOptions& options) {
  const NpzFile archive(std::string(content), name);
  const std::string array = choose_array(archive, name, options);
  PointCloudFile file =
      parse_npy_cloud(archive.bytes(array), name + ": array " + quoted_text(array), options);
  file.format = PointCloudFormat::kNpz;
  return file;
}

}  // namespace arbox::io::internal
