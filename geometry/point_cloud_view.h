#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstring>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace arbox::geometry {

/// Number formats of a channel in memory, little-endian as in the machine.
enum class ScalarType { kInt8, kUint8, kInt16, kUint16, kInt32, kUint32, kFloat32, kFloat64 };

/// Bytes of one scalar.
std::size_t size_of(ScalarType type);

/// One named number of every point, `offset` bytes after the point's first byte.
struct Channel {
  std::string name;
  std::size_t offset = 0;
  ScalarType type = ScalarType::kFloat32;
};

/// A read-only view of points in somebody else's memory: a PCL cloud, a file, a driver's buffer.
///
/// Point i starts at data + i * stride. Coordinates x, y, z are consecutive float32 at byte `xyz`
/// of a point (metres). Further numbers are named channels; the names with a meaning are
/// `intensity` (0..1), `r g b` (uint8 or float 0..1), `normal_x normal_y normal_z`, `ring`
/// (laser index) and `time` (seconds from the scan's start).
///
/// Nothing is owned or copied; the memory must outlive the view. Points may hold non-finite
/// coordinates; whoever reads decides (readers in io drop them by default). An empty view
/// (count 0, data may be null) is valid everywhere.
class PointCloudView {
 public:
  PointCloudView() = default;
  /// Throws InvalidArgument if the stride cannot hold the coordinates or a channel, or if data is
  /// null while count > 0.
  PointCloudView(const void* data, std::size_t count, std::size_t stride, std::size_t xyz = 0,
                 std::vector<Channel> channels = {});

  /// Tightly packed float32 rows; row = x y z followed by the named channels.
  static PointCloudView packed(const float* data, std::size_t count,
                               const std::vector<std::string>& channels = {});

  std::size_t size() const { return count_; }
  bool empty() const { return count_ == 0; }
  std::size_t stride() const { return stride_; }
  const std::byte* data() const { return data_; }
  const std::vector<Channel>& channels() const { return channels_; }

  /// Coordinates of point i < size(), metres.
  Eigen::Vector3f position(std::size_t i) const {
    Eigen::Vector3f result;
    std::memcpy(result.data(), data_ + i * stride_ + xyz_, 3 * sizeof(float));
    return result;
  }

  /// The channel of that name, or nullptr.
  const Channel* find(std::string_view name) const;

  /// The value of a channel of this view at point i < size(), converted to double.
  double value(const Channel& channel, std::size_t i) const;

 private:
  const std::byte* data_ = nullptr;
  std::size_t count_ = 0;
  std::size_t stride_ = 3 * sizeof(float);
  std::size_t xyz_ = 0;
  std::vector<Channel> channels_;
};

/// Points that own their memory: float32 rows of x, y, z and the named channels.
struct PointCloud {
  /// Names of the columns after x, y, z.
  std::vector<std::string> channels;
  /// size() * (3 + channels.size()) numbers, row after row.
  std::vector<float> values;

  std::size_t columns() const { return 3 + channels.size(); }
  std::size_t size() const { return values.size() / columns(); }
  PointCloudView view() const { return PointCloudView::packed(values.data(), size(), channels); }
};

}  // namespace arbox::geometry
