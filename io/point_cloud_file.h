#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "arbox/base/option_field.h"
#include "arbox/geometry/point_cloud_view.h"

/// \file
/// Point-cloud files: PCD, PLY, KITTI .bin, NumPy .npy and .npz, delimited text.
///
/// Coordinates are as in the file (a PCD's VIEWPOINT is told in the report and not applied, as PCL
/// does), rounded to float32. The order of points stays. Channels with a meaning get one name and
/// unit, whatever the file calls them:
///
/// | channel | from | unit |
/// |---|---|---|
/// | `intensity` | intensity, i, reflectance, reflectivity, remission, scalar_intensity | 0..1, see
/// `scale_intensity` | | `r g b` | packed rgb or rgba of PCD; red green blue; r g b | 0..1: bytes
/// over 255, 16-bit numbers over 65535, other numbers over 255 if one is above 1 | | `normal_x
/// normal_y normal_z` | normal_x.., nx ny nz | unit vector | | `ring` | ring, laser_id, row | laser
/// index | | `time` | time, timestamp, time_stamp, gps_time, t, offset_time, time_offset | seconds;
/// integer types hold nanoseconds; times above 1e5 s are counted from the earliest |
///
/// Other scalar fields keep their names; a field with COUNT n > 1 becomes name_0 .. name_{n-1}.
/// Alpha and fields named `_` are left out.

namespace arbox::io {

enum class PointCloudFormat { kPcd, kPly, kBin, kNpy, kNpz, kText };

/// "pcd", "ply", "bin", "npy", "npz", "text".
std::string_view name_of(PointCloudFormat format);

/// The format of a file name's extension (any case): .pcd .ply .bin .npy .npz, and .csv .tsv .txt
/// .xyz .xyzrgb .xyzn .pts .asc for text.
std::optional<PointCloudFormat> format_of_extension(const std::filesystem::path& path);

struct ReadOptions {
  /// Columns of files that do not name theirs (.bin, .npy, .npz, text without a header): either
  /// their number ("5") or their names in order ("x", "y", "z", "intensity", "_" to skip one).
  /// Empty: 3 x y z; 4 and intensity; 5 and ring; 6 x y z and colours, or normals if one of the
  /// three is negative; 7 x y z intensity and colours. Refused for files that name their columns.
  std::vector<std::string> channels = {};
  /// Keep points with a coordinate that is not finite. Dropped ones are counted in the report.
  bool keep_non_finite = false;
  /// Bring intensity to 0..1: bytes over 255, 16-bit numbers over 65535; other numbers stay unless
  /// one is above 1, then over 255, 65535 or the largest, whichever is the first not below it.
  bool scale_intensity = true;
  /// Which array of a .npz archive; empty takes the only one, or points, pc, point_cloud, xyz.
  std::string array = "";
  /// "pcd", "ply", "bin", "npy", "npz" or "text"; empty asks the content, then the extension.
  std::string format = "";

  template <class Visitor>
  static void describe(Visitor& visitor) {
    visitor.field("channels", &ReadOptions::channels,
                  {.help = "Columns of files that do not name theirs: their number or names"});
    visitor.field("keep_non_finite", &ReadOptions::keep_non_finite,
                  {.help = "Keep points with a coordinate that is not finite"});
    visitor.field("scale_intensity", &ReadOptions::scale_intensity,
                  {.help = "Bring intensity to 0..1"});
    visitor.field("array", &ReadOptions::array, {.help = "Which array of a .npz archive"});
    visitor.field("format", &ReadOptions::format,
                  {.help = "Format, whatever the content and the extension say",
                   .choices = {"", "pcd", "ply", "bin", "npy", "npz", "text"}});
  }
};

/// Points with a report on the file.
struct PointCloudFile {
  geometry::PointCloud points = {};
  PointCloudFormat format = PointCloudFormat::kPcd;
  /// "ascii", "binary", "binary_compressed", "binary_little_endian", "binary_big_endian",
  /// "comma-separated" and the like; a number type for arrays.
  std::string encoding = {};
  /// Points in the file; points.size() + dropped.
  std::uint64_t points_in_file = 0;
  /// Points with a coordinate that is not finite, kept or not.
  std::uint64_t non_finite = 0;
  std::uint64_t dropped = 0;
  /// Image-like order of the file's points, row by row; height is 1 for a plain list.
  std::uint64_t width = 0, height = 1;
  /// A PCD's sensor pose x y z qw qx qy qz, not applied.
  std::array<double, 7> viewpoint{0, 0, 0, 1, 0, 0, 0};
  /// Bytes after the last point of a binary PCD or .npy that nothing describes.
  std::uint64_t unused_bytes = 0;
  /// What intensities were divided by.
  double intensity_divisor = 1.0;
  /// The file's time of time 0, seconds.
  double time_origin = 0.0;
};

/// Reads a file. The content's first bytes choose the format where they can (PCD, PLY, .npy, .npz),
/// else the extension. A file whose header announces no points is a result; a file of no bytes is
/// refused in every format. Throws IoError for a missing file or a
/// folder, FormatError (path, line or byte, what was expected, what came) for bad content, among it
/// a .bin whose number of columns is not certain, InvalidArgument for options that do not fit.
/// Memory is at most a small multiple of the file's size, whatever its header claims.
PointCloudFile read_point_cloud(const std::filesystem::path& path, const ReadOptions& options = {});

/// The same for content in memory; `name` goes into messages and its extension counts.
PointCloudFile parse_point_cloud(std::string_view content, const std::string& name,
                                 const ReadOptions& options = {});

/// The files of a folder (not of its subfolders) with an extension of a point cloud, .txt apart,
/// which may be anything; in order of their names. Throws IoError.
std::vector<std::filesystem::path> list_point_clouds(const std::filesystem::path& folder);

struct WriteOptions {
  /// PCD: "binary" (default), "ascii", "binary_compressed". PLY: "binary", "ascii". Empty: default.
  std::string encoding = "";
  /// Channels to write after x y z, in this order; each must be in the cloud. Empty: every channel,
  /// but for .bin intensity alone (zeros if the cloud has none), as its readers expect four
  /// numbers.
  std::vector<std::string> channels = {};
  /// "pcd", "ply", "bin", "npy", "npz" or "text"; empty asks the extension.
  std::string format = "";

  template <class Visitor>
  static void describe(Visitor& visitor) {
    visitor.field("encoding", &WriteOptions::encoding,
                  {.help = "Encoding of PCD and PLY",
                   .choices = {"", "ascii", "binary", "binary_compressed"}});
    visitor.field("channels", &WriteOptions::channels,
                  {.help = "Channels to write after x, y, z (default: all; .bin: intensity)"});
    visitor.field("format", &WriteOptions::format,
                  {.help = "Format, whatever the extension says",
                   .choices = {"", "pcd", "ply", "bin", "npy", "npz", "text"}});
  }
};

/// The bytes of a file of that format. Numbers are float32; in PCD and PLY colours are bytes (rgb,
/// red green blue) and `ring` and `label` whole numbers if their values are. Text is
/// comma-separated with a header and the shortest digits that read back the same. .npz holds one
/// array `points`. Throws InvalidArgument for options that do not fit, and in PCD, PLY and text for
/// channels of one name or with blanks, commas, semicolons or quotation marks in it.
std::string encode_point_cloud(const geometry::PointCloudView& points, PointCloudFormat format,
                               const WriteOptions& options = {});

/// Writes a file beside its place and renames it. Throws IoError, InvalidArgument.
void write_point_cloud(const std::filesystem::path& path, const geometry::PointCloudView& points,
                       const WriteOptions& options = {});

}  // namespace arbox::io
