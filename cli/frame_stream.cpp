#include "arbox/cli/frame_stream.h"

#include <algorithm>
#include <array>
#include <iostream>
#include <nlohmann/json.hpp>

#include "arbox/base/error.h"
#include "arbox/cli/command_line.h"
#include "arbox/io/detection_json.h"

namespace arbox::cli {
namespace {

constexpr std::size_t kHeaderBytes = 8;
constexpr std::uint32_t kFewestChannels = 3;
constexpr std::uint32_t kMostChannels = 64;

/// What follows of the stream cannot be told apart any more.
class BrokenStream : public FormatError {
 public:
  using FormatError::FormatError;
};

std::uint32_t little_endian(const char* bytes) {
  std::uint32_t value = 0;
  for (int i = 3; i >= 0; --i) value = value << 8 | static_cast<unsigned char>(bytes[i]);
  return value;
}

/// Grows with what comes, so that a false count costs no memory.
std::string read_bytes(std::istream& input, std::uint32_t count) {
  constexpr std::size_t kStep = std::size_t{1} << 22;
  std::string bytes;
  while (bytes.size() < count) {
    const std::size_t old = bytes.size();
    const std::size_t step = std::min<std::size_t>(kStep, count - old);
    bytes.resize(old + step);
    input.read(bytes.data() + old, static_cast<std::streamsize>(step));
    const auto got = static_cast<std::size_t>(input.gcount());
    if (got < step) {
      throw BrokenStream("expected " + std::to_string(count) + " bytes of points, got " +
                         std::to_string(old + got) + " before the input ended");
    }
  }
  return bytes;
}

io::PointCloudFile parse_frame(const std::string& points, std::uint32_t channels,
                               const std::string& source, io::ReadOptions options) {
  if (channels < kFewestChannels || channels > kMostChannels) {
    throw FormatError("expected " + std::to_string(kFewestChannels) + " to " +
                      std::to_string(kMostChannels) + " channels, got " + std::to_string(channels));
  }
  if (points.size() % (sizeof(float) * channels) != 0) {
    throw FormatError("expected whole points of " + std::to_string(channels) + " float32, got " +
                      std::to_string(points.size()) + " bytes");
  }
  const std::vector<std::string>& names = options.channels;
  const std::string asked = names.size() == 1 ? names[0] : std::to_string(names.size());
  if (!names.empty() && asked != std::to_string(channels)) {
    throw FormatError("expected the " + asked + " channels of --channels, got " +
                      std::to_string(channels));
  }
  if (points.empty()) return {};
  options.format = "bin";
  if (options.channels.empty()) options.channels = {std::to_string(channels)};
  return io::parse_point_cloud(points, source, options);
}

std::string answer(std::istream& input, const std::string& header, const std::string& source,
                   const detectors::Detector& detector, const detectors::DetectionRequest& request,
                   const io::ReadOptions& read) {
  if (header.size() < kHeaderBytes) {
    throw BrokenStream("expected a header of 8 bytes, got " + std::to_string(header.size()) +
                       " before the input ended");
  }
  const std::uint32_t bytes = little_endian(header.data());
  if (bytes > kMostFrameBytes) {
    throw BrokenStream("expected at most " + std::to_string(kMostFrameBytes) +
                       " bytes of points, got " + std::to_string(bytes) + " announced");
  }
  const std::string points = read_bytes(input, bytes);
  const io::PointCloudFile file =
      parse_frame(points, little_endian(header.data() + 4), source, read);
  detectors::DetectionResult result = detector.detect(file.points.view(), request);
  return io::format_detections_json({.source = source, .detections = std::move(result.detections)});
}

}  // namespace

FrameCount answer_frames(std::istream& input, std::ostream& output,
                         const detectors::Detector& detector,
                         const detectors::DetectionRequest& request, const io::ReadOptions& read) {
  FrameCount count;
  for (bool whole = true; whole; ++count.frames) {
    std::string header(kHeaderBytes, '\0');
    input.read(header.data(), kHeaderBytes);
    header.resize(static_cast<std::size_t>(input.gcount()));
    if (header.empty()) break;
    const std::string source = "frame " + std::to_string(count.frames);
    std::string line;
    try {
      line = answer(input, header, source, detector, request, read);
    } catch (const Error& error) {
      whole = dynamic_cast<const BrokenStream*>(&error) == nullptr;
      ++count.refused;
      line = nlohmann::ordered_json{{"source", source}, {"error", fold_lines(error.what())}}.dump();
    }
    output << line << '\n' << std::flush;
  }
  return count;
}

}  // namespace arbox::cli
