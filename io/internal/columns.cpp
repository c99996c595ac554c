#include "arbox/io/internal/columns.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <set>
#include <span>
#include <utility>

#include "arbox/base/error.h"
#include "arbox/io/internal/load_number.h"
#include "arbox/io/internal/parse.h"

namespace arbox::io::internal {
namespace {

// One channel of the result: value = number * scale - origin.
struct Channel {
  Column column;
  double scale = 1.0;
  double origin = 0.0;
};

std::string canonical_name(const std::string& given) {
  static constexpr std::pair<std::string_view, std::string_view> kAliases[] = {
      {"i", "intensity"},
      {"reflectance", "intensity"},
      {"reflectivity", "intensity"},
      {"remission", "intensity"},
      {"scalar_intensity", "intensity"},
      {"red", "r"},
      {"green", "g"},
      {"blue", "b"},
      {"nx", "normal_x"},
      {"ny", "normal_y"},
      {"nz", "normal_z"},
      {"laser_id", "ring"},
      {"row", "ring"},
      {"timestamp", "time"},
      {"time_stamp", "time"},
      {"gps_time", "time"},
      {"t", "time"},
      {"offset_time", "time"},
      {"time_offset", "time"},
  };
  const std::string name = lower(given);
  for (const auto& [alias, canonical] : kAliases) {
    if (alias == name) return std::string(canonical);
  }
  static const std::set<std::string, std::less<>> kKnown{
      "x", "y",        "z",        "intensity", "r",    "g",
      "b", "normal_x", "normal_y", "normal_z",  "ring", "time"};
  return kKnown.contains(name) ? name : given;
}

// An alias gives way to a column that has the name itself.
void rename(std::vector<Column>& columns, const std::string& file) {
  std::set<std::string> given;
  for (const Column& column : columns) {
    if (!given.insert(column.name).second) fail(file, "field '" + column.name + "' comes twice");
  }
  for (Column& column : columns) {
    const std::string name = canonical_name(column.name);
    if (name != column.name && given.insert(name).second) column.name = name;
  }
}

void sort_coordinates_first(std::vector<Column>& columns, const std::string& file) {
  std::vector<std::string> names;
  for (const Column& column : columns) names.push_back(column.name);
  constexpr std::string_view kAxes[] = {"x", "y", "z"};
  for (std::ptrdiff_t axis = 0; axis < 3; ++axis) {
    const auto found = std::find_if(
        columns.begin() + std::min<std::ptrdiff_t>(axis, std::ssize(columns)), columns.end(),
        [&](const Column& column) { return column.name == kAxes[axis]; });
    if (found == columns.end()) {
      if (names.size() > 20) names.resize(20);
      fail(file, "expected fields x, y and z, got " + (names.empty() ? "none" : listed(names)));
    }
    std::rotate(columns.begin() + axis, found, found + 1);
  }
}

// The smallest and largest finite number; (0, 0) if there is none.
std::pair<double, double> range_of(const Column& column, std::size_t rows) {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  with_type(column.type, [&](auto number) {
    using Number = decltype(number);
    for (std::size_t i = 0; i < rows; ++i) {
      const auto value = static_cast<double>(
          load_number<Number>(column.data + i * column.stride, column.big_endian));
      if (!std::isfinite(value)) continue;
      low = std::min(low, value);
      high = std::max(high, value);
    }
  });
  return low <= high ? std::pair(low, high) : std::pair(0.0, 0.0);
}

double full_scale(NumberType type) {
  if (type == NumberType::kUint8) return 255.0;
  if (type == NumberType::kUint16) return 65535.0;
  return 0.0;
}

double intensity_divisor(const Column& column, std::size_t rows) {
  if (const double full = full_scale(column.type); full > 0.0) return full;
  const double high = range_of(column, rows).second;
  for (const double divisor : {1.0, 255.0, 65535.0}) {
    if (high <= divisor) return divisor;
  }
  return high;
}

void set_color_scale(std::span<Channel> colors, std::size_t rows) {
  double high = 0.0;
  for (const Channel& color : colors) {
    if (full_scale(color.column.type) == 0.0) {
      high = std::max(high, range_of(color.column, rows).second);
    }
  }
  for (Channel& color : colors) {
    const double full = full_scale(color.column.type);
    color.scale = 1.0 / (full > 0.0 ? full : high > 1.0 ? 255.0 : 1.0);
  }
}

void set_time_scale(Channel& channel, PointCloudFile& file) {
  constexpr double kNanosecond = 1e-9, kAbsolute = 1e5;
  const Column& column = channel.column;
  channel.scale = is_floating(column.type) ? 1.0 : kNanosecond;
  const auto [low, high] = range_of(column, file.points_in_file);
  if (high * channel.scale > kAbsolute) channel.origin = low * channel.scale;
  file.time_origin = channel.origin;
}

std::vector<Channel> with_units(std::vector<Column> columns, PointCloudFile& file,
                                const ReadOptions& options) {
  std::vector<Channel> channels, colors;
  for (Column& column : columns) channels.push_back({std::move(column)});
  const auto is_color = [](const Channel& channel) {
    return channel.column.name == "r" || channel.column.name == "g" || channel.column.name == "b";
  };
  std::copy_if(channels.begin(), channels.end(), std::back_inserter(colors), is_color);
  set_color_scale(colors, file.points_in_file);
  std::size_t next_color = 0;
  for (Channel& channel : channels) {
    if (is_color(channel)) channel.scale = colors[next_color++].scale;
    if (channel.column.name == "intensity" && options.scale_intensity) {
      file.intensity_divisor = intensity_divisor(channel.column, file.points_in_file);
      channel.scale = 1.0 / file.intensity_divisor;
    }
    if (channel.column.name == "time") set_time_scale(channel, file);
  }
  return channels;
}

float to_float(double value) {
  constexpr double kLargest = std::numeric_limits<float>::max();
  if (value > kLargest) return std::numeric_limits<float>::infinity();
  if (value < -kLargest) return -std::numeric_limits<float>::infinity();
  return static_cast<float>(value);
}

// Rows [begin, end) of one channel into the column at `to` of rows of `width` numbers.
void convert(const Channel& channel, std::size_t begin, std::size_t end, float* to,
             std::size_t width) {
  const Column& column = channel.column;
  const bool plain = channel.scale == 1.0 && channel.origin == 0.0;
  if (plain && column.type == NumberType::kFloat32 && !column.big_endian) {
    for (std::size_t i = begin; i < end; ++i, to += width) {
      std::memcpy(to, column.data + i * column.stride, sizeof(float));
    }
    return;
  }
  with_type(column.type, [&](auto number) {
    using Number = decltype(number);
    for (std::size_t i = begin; i < end; ++i, to += width) {
      const auto value = static_cast<double>(
          load_number<Number>(column.data + i * column.stride, column.big_endian));
      *to = to_float(plain ? value : value * channel.scale - channel.origin);
    }
  });
}

// Rows that already are what the result shall hold need no conversion.
bool is_packed(const std::vector<Channel>& channels) {
  for (std::size_t i = 0; i < channels.size(); ++i) {
    const auto& [column, scale, origin] = channels[i];
    if (column.type != NumberType::kFloat32 || column.big_endian || scale != 1.0 || origin != 0.0 ||
        column.stride != channels.size() * sizeof(float) ||
        column.data != channels[0].column.data + i * sizeof(float)) {
      return false;
    }
  }
  return true;
}

// Moves finite rows together; gives their number.
std::size_t compact(float* rows, std::size_t count, std::size_t width) {
  std::size_t kept = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const float* row = rows + i * width;
    // x - x is 0 for finite numbers and NaN for the others.
    if ((row[0] - row[0]) + (row[1] - row[1]) + (row[2] - row[2]) != 0.0F) continue;
    if (kept < i) std::memmove(rows + kept * width, row, width * sizeof(float));
    ++kept;
  }
  return kept;
}

void convert_rows(const std::vector<Channel>& channels, PointCloudFile& file,
                  const ReadOptions& options) {
  constexpr std::size_t kBlockNumbers = 4096;
  const std::size_t width = channels.size(), rows = file.points_in_file;
  if (rows == 0) return;
  const std::size_t block = std::max<std::size_t>(1, kBlockNumbers / width);
  const bool packed = is_packed(channels);
  std::vector<float>& values = file.points.values;
  values.reserve(rows * width);
  std::vector<float> buffer(std::min(block, rows) * width);
  for (std::size_t begin = 0; begin < rows; begin += block) {
    const std::size_t count = std::min(block, rows - begin);
    if (packed) {
      std::memcpy(buffer.data(), channels[0].column.data + begin * width * sizeof(float),
                  count * width * sizeof(float));
    } else {
      for (std::size_t c = 0; c < width; ++c) {
        convert(channels[c], begin, begin + count, buffer.data() + c, width);
      }
    }
    if (!options.keep_non_finite) {
      const std::size_t kept = compact(buffer.data(), count, width);
      file.non_finite += count - kept;
      values.insert(values.end(), buffer.data(), buffer.data() + kept * width);
      continue;
    }
    values.insert(values.end(), buffer.data(), buffer.data() + count * width);
    file.non_finite += count - compact(buffer.data(), count, width);
  }
  file.dropped = options.keep_non_finite ? 0 : file.non_finite;
}

}  // namespace

PointCloudFile assemble(std::vector<Column> columns, PointCloudFile file, const std::string& name,
                        const ReadOptions& options) {
  std::erase_if(columns, [](const Column& column) {
    return column.name == "_" || lower(column.name) == "alpha";
  });
  rename(columns, name);
  sort_coordinates_first(columns, name);
  const std::vector<Channel> channels = with_units(std::move(columns), file, options);
  for (std::size_t i = 3; i < channels.size(); ++i) {
    file.points.channels.push_back(channels[i].column.name);
  }
  if (file.width == 0 && file.height == 1) file.width = file.points_in_file;
  convert_rows(channels, file, options);
  return file;
}

}  // namespace arbox::io::internal
