#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>

#include "arbox/base/error.h"
#include "arbox/io/file.h"
#include "arbox/io/internal/parse.h"
#include "arbox/io/internal/point_cloud_encoders.h"
#include "arbox/io/internal/point_cloud_format.h"
#include "arbox/io/internal/text.h"
#include "arbox/io/npz.h"
#include "arbox/io/point_cloud_file.h"

namespace arbox::io {
namespace internal {
namespace {

bool is_color(std::string_view name) { return name == "r" || name == "g" || name == "b"; }

}  // namespace

float Output::value(std::size_t source, std::size_t i) const {
  if (source < 3) return points.position(i)[static_cast<Eigen::Index>(source)];
  const geometry::Channel& channel = *channels[source - 3];
  const double value = points.value(channel, i);
  const bool bytes = is_color(channel.name) && channel.type == geometry::ScalarType::kUint8;
  return static_cast<float>(bytes ? value / 255.0 : value);
}

std::uint8_t Output::color_byte(std::size_t source, std::size_t i) const {
  const float color = value(source, i);
  return color > 0.0F ? static_cast<std::uint8_t>(std::lround(std::min(color, 1.0F) * 255.0F)) : 0;
}

std::size_t Output::find(std::string_view name) const {
  for (std::size_t i = 0; i < channels.size(); ++i) {
    if (channels[i]->name == name) return i + 3;
  }
  return 0;
}

NumberType Output::type_of(std::size_t source) const {
  if (source < 3) return NumberType::kFloat32;
  const std::string& name = channels[source - 3]->name;
  if (name != "ring" && name != "label") return NumberType::kFloat32;
  // A float holds whole numbers exactly up to 2^24.
  const float most = name == "ring" ? 65535.0F : 16777216.0F;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const float number = value(source, i);
    if (!(number >= 0.0F && number <= most && number == std::floor(number))) {
      return NumberType::kFloat32;
    }
  }
  return name == "ring" ? NumberType::kUint16 : NumberType::kUint32;
}

void append_number_bytes(std::string& bytes, NumberType type, float value) {
  const auto append = [&](auto number) {
    bytes.append(reinterpret_cast<const char*>(&number), sizeof number);
  };
  switch (type) {
    case NumberType::kUint8:
      return append(static_cast<std::uint8_t>(value));
    case NumberType::kUint16:
      return append(static_cast<std::uint16_t>(value));
    case NumberType::kUint32:
      return append(static_cast<std::uint32_t>(value));
    default:
      return append(value);
  }
}

void append_shortest(std::string& text, NumberType type, float value) {
  char buffer[32];
  const auto end = is_floating(type) ? std::to_chars(buffer, buffer + sizeof buffer, value)
                                     : std::to_chars(buffer, buffer + sizeof buffer,
                                                     static_cast<std::uint32_t>(value));
  text.append(buffer, end.ptr);
}

std::string encode_csv(const Output& output) {
  std::string text = "x,y,z";
  for (const geometry::Channel* channel : output.channels) text += "," + channel->name;
  text += '\n';
  const std::size_t width = 3 + output.channels.size();
  for (std::size_t i = 0; i < output.points.size(); ++i) {
    for (std::size_t c = 0; c < width; ++c) {
      append_shortest(text, NumberType::kFloat32, output.value(c, i));
      text += c + 1 < width ? ',' : '\n';
    }
  }
  return text;
}

}  // namespace internal

namespace {

using internal::Output;

std::vector<const geometry::Channel*> selected(const geometry::PointCloudView& points,
                                               const std::vector<std::string>& wanted) {
  std::vector<const geometry::Channel*> channels;
  for (const std::string& name : wanted) {
    const geometry::Channel* channel = points.find(name);
    if (channel == nullptr) {
      std::vector<std::string> known;
      for (const auto& existing : points.channels()) known.push_back(existing.name);
      throw InvalidArgument("channels: no channel " + internal::quoted_text(name) +
                            " to write; the cloud has " +
                            (known.empty() ? "only x, y, z" : internal::listed(known)));
    }
    channels.push_back(channel);
  }
  if (!wanted.empty()) return channels;
  for (const auto& channel : points.channels()) channels.push_back(&channel);
  return channels;
}

bool names_columns(PointCloudFormat format) {
  return format == PointCloudFormat::kPcd || format == PointCloudFormat::kPly ||
         format == PointCloudFormat::kText;
}

/// Names stand bare in headers, so that readers would split or merge others.
void require_readable_names(const Output& output) {
  std::vector<std::string> seen{"x", "y", "z"};
  for (const geometry::Channel* channel : output.channels) {
    const std::string& name = channel->name;
    const bool bare = std::none_of(name.begin(), name.end(), [](unsigned char letter) {
      return letter <= ' ' || letter == 0x7f || letter == ',' || letter == ';' || letter == '"';
    });
    if (name.empty() || !bare) {
      throw InvalidArgument(
          "channels: expected names without blanks, commas, semicolons and "
          "quotation marks, got " +
          internal::quoted_text(name));
    }
    if (std::find(seen.begin(), seen.end(), name) != seen.end()) {
      throw InvalidArgument("channels: expected each name once, got " +
                            internal::quoted_text(name) + " a second time");
    }
    seen.push_back(name);
  }
}

std::vector<float> rows_of(const Output& output) {
  const std::size_t width = 3 + output.channels.size();
  std::vector<float> rows;
  rows.reserve(output.points.size() * width);
  for (std::size_t i = 0; i < output.points.size(); ++i) {
    for (std::size_t c = 0; c < width; ++c) rows.push_back(output.value(c, i));
  }
  return rows;
}

std::string encode_array(const Output& output) {
  return encode_npy<float>(rows_of(output), {output.points.size(), 3 + output.channels.size()});
}

std::string encode_bin(const geometry::PointCloudView& points, const WriteOptions& options) {
  Output output{points, {}};
  const geometry::Channel* intensity = points.find("intensity");
  if (!options.channels.empty()) {
    output.channels = selected(points, options.channels);
  } else if (intensity != nullptr) {
    output.channels = {intensity};
  }
  std::vector<float> rows = rows_of(output);
  if (options.channels.empty() && intensity == nullptr) {
    std::vector<float> with_zeros(points.size() * 4);
    for (std::size_t i = 0; i < points.size(); ++i) {
      std::copy_n(rows.begin() + static_cast<std::ptrdiff_t>(3 * i), 3,
                  with_zeros.begin() + static_cast<std::ptrdiff_t>(4 * i));
    }
    rows = std::move(with_zeros);
  }
  return {reinterpret_cast<const char*>(rows.data()), rows.size() * sizeof(float)};
}

}  // namespace

std::string encode_point_cloud(const geometry::PointCloudView& points, PointCloudFormat format,
                               const WriteOptions& options) {
  const auto require_encoding = [&](std::initializer_list<std::string_view> known) {
    if (options.encoding.empty() ||
        std::find(known.begin(), known.end(), options.encoding) != known.end()) {
      return;
    }
    throw InvalidArgument("encoding: " + std::string(name_of(format)) + " has no encoding " +
                          internal::quoted_text(options.encoding));
  };
  if (format == PointCloudFormat::kBin) {
    require_encoding({});
    return encode_bin(points, options);
  }
  const Output output{points, selected(points, options.channels)};
  if (names_columns(format)) require_readable_names(output);
  switch (format) {
    case PointCloudFormat::kPcd:
      require_encoding({"ascii", "binary", "binary_compressed"});
      return internal::encode_pcd(output, options.encoding.empty() ? "binary" : options.encoding);
    case PointCloudFormat::kPly:
      require_encoding({"ascii", "binary"});
      return internal::encode_ply(output, options.encoding.empty() ? "binary" : options.encoding);
    case PointCloudFormat::kNpy:
      require_encoding({});
      return encode_array(output);
    case PointCloudFormat::kNpz:
      require_encoding({});
      return encode_npz({{"points", encode_array(output)}});
    case PointCloudFormat::kText:
    case PointCloudFormat::kBin:
      break;
  }
  require_encoding({});
  return internal::encode_csv(output);
}

void write_point_cloud(const std::filesystem::path& path, const geometry::PointCloudView& points,
                       const WriteOptions& options) {
  const auto format =
      options.format.empty() ? format_of_extension(path) : internal::format_named(options.format);
  if (!format) {
    throw InvalidArgument(path.string() +
                          ": the extension names no point-cloud format (.pcd, .ply, .bin, .npy, "
                          ".npz, .csv); say which with the option format");
  }
  write_file(path, encode_point_cloud(points, *format, options));
}

}  // namespace arbox::io
