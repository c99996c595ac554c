#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "arbox/io/number_type.h"
#include "arbox/io/point_cloud_file.h"

namespace arbox::io::internal {

/// One number of every point, somewhere in memory; row i is at data + i * stride.
struct Column {
  std::string name;
  NumberType type = NumberType::kFloat32;
  const std::byte* data = nullptr;
  std::size_t stride = 0;
  bool big_endian = false;
};

/// The most numbers of one point that a file may have.
inline constexpr std::size_t kMostColumns = 4096;

/// Gives channels their names and units, converts to float32 and drops non-finite points as the
/// options say. `file` holds what the decoder already knows; points_in_file rows are read. Throws
/// FormatError if x, y or z is missing or a name comes twice.
PointCloudFile assemble(std::vector<Column> columns, PointCloudFile file, const std::string& name,
                        const ReadOptions& options);

/// Names for `count` columns of a file that does not name them, as ReadOptions::channels says.
/// `negative_tail`: a value of the last three columns is negative.
std::vector<std::string> column_names(std::size_t count, bool negative_tail,
                                      const std::string& name, const ReadOptions& options);

/// The number of columns that options.channels asks for, or 0.
std::size_t columns_asked(const ReadOptions& options);

/// Throws InvalidArgument if options.channels is given for a file that names its own columns.
void require_no_channels(const std::string& name, const ReadOptions& options);

/// True if a number in the last three of six columns is below 0.
bool has_negative_tail(const std::vector<Column>& columns, std::size_t rows);

/// Decoders; each takes the whole content.
PointCloudFile parse_pcd(std::string_view content, const std::string& name, const ReadOptions&);
PointCloudFile parse_ply(std::string_view content, const std::string& name, const ReadOptions&);
PointCloudFile parse_bin(std::string_view content, const std::string& name, const ReadOptions&);
PointCloudFile parse_npy_cloud(std::string_view content, const std::string& name,
                               const ReadOptions&);
PointCloudFile parse_npz_cloud(std::string_view content, const std::string& name,
                               const ReadOptions&);
PointCloudFile parse_text_cloud(std::string_view content, const std::string& name,
                                const ReadOptions&);

}  // namespace arbox::io::internal
