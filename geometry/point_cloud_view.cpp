#include "arbox/geometry/point_cloud_view.h"

#include <algorithm>
#include <cstdint>
#include <utility>

#include "arbox/base/error.h"

namespace arbox::geometry {
namespace {

template <class T>
double read(const std::byte* from) {
  T value;
  std::memcpy(&value, from, sizeof value);
  return static_cast<double>(value);
}

}  // namespace

std::size_t size_of(ScalarType type) {
  switch (type) {
    case ScalarType::kInt8:
    case ScalarType::kUint8:
      return 1;
    case ScalarType::kInt16:
    case ScalarType::kUint16:
      return 2;
    case ScalarType::kInt32:
    case ScalarType::kUint32:
    case ScalarType::kFloat32:
      return 4;
    case ScalarType::kFloat64:
      return 8;
  }
  throw InvalidArgument("size_of: unknown scalar type");
}

PointCloudView::PointCloudView(const void* data, std::size_t count, std::size_t stride,
                               std::size_t xyz, std::vector<Channel> channels)
    : data_(static_cast<const std::byte*>(data)),
      count_(count),
      stride_(stride),
      xyz_(xyz),
      channels_(std::move(channels)) {
  const auto require = [&](std::size_t end, const std::string& name) {
    if (end <= stride_) return;
    throw InvalidArgument("PointCloudView: " + name + " ends at byte " + std::to_string(end) +
                          " of a point, but the stride is " + std::to_string(stride_) + " bytes");
  };
  if (data_ == nullptr && count_ > 0) {
    throw InvalidArgument("PointCloudView: data is null, but count is " + std::to_string(count_));
  }
  require(xyz_ + 3 * sizeof(float), "xyz");
  for (const Channel& channel : channels_) {
    require(channel.offset + size_of(channel.type), "channel '" + channel.name + "'");
  }
}

PointCloudView PointCloudView::packed(const float* data, std::size_t count,
                                      const std::vector<std::string>& channels) {
  std::vector<Channel> described;
  for (std::size_t i = 0; i < channels.size(); ++i) {
    described.push_back({channels[i], (3 + i) * sizeof(float), ScalarType::kFloat32});
  }
  return {data, count, (3 + channels.size()) * sizeof(float), 0, std::move(described)};
}

const Channel* PointCloudView::find(std::string_view name) const {
  const auto found = std::find_if(channels_.begin(), channels_.end(),
                                  [&](const Channel& channel) { return channel.name == name; });
  return found == channels_.end() ? nullptr : &*found;
}

double PointCloudView::value(const Channel& channel, std::size_t i) const {
  const std::byte* from = data_ + i * stride_ + channel.offset;
  switch (channel.type) {
    case ScalarType::kInt8:
      return read<std::int8_t>(from);
    case ScalarType::kUint8:
      return read<std::uint8_t>(from);
    case ScalarType::kInt16:
      return read<std::int16_t>(from);
    case ScalarType::kUint16:
      return read<std::uint16_t>(from);
    case ScalarType::kInt32:
      return read<std::int32_t>(from);
    case ScalarType::kUint32:
      return read<std::uint32_t>(from);
    case ScalarType::kFloat32:
      return read<float>(from);
    case ScalarType::kFloat64:
      return read<double>(from);
  }
  throw InvalidArgument("PointCloudView::value: unknown scalar type");
}

}  // namespace arbox::geometry
