#pragma once

#include <cstdint>
#include <iosfwd>

#include "arbox/detectors/detector.h"
#include "arbox/io/point_cloud_file.h"

namespace arbox::cli {

/// The most bytes of points that a frame may announce.
inline constexpr std::uint32_t kMostFrameBytes = std::uint32_t{1} << 30;

struct FrameCount {
  std::uint64_t frames = 0;
  std::uint64_t refused = 0;
};

/// Answers each frame of `input` with one line of JSON on `output`, flushed, until the input ends.
///
/// A frame is two little-endian uint32, the byte count of the points and the channel count, then
/// the points: rows of that many little-endian float32, x y z first. 0 bytes are an empty cloud.
/// The answer to frame i is what `arbox detect --format jsonl` writes with the source "frame i", or
/// {"source": "frame i", "error": "..."} for a frame that cannot be used: it is passed over, but
/// for one that is cut or announces more than kMostFrameBytes, which is the last.
FrameCount answer_frames(std::istream& input, std::ostream& output,
                         const detectors::Detector& detector,
                         const detectors::DetectionRequest& request, const io::ReadOptions& read);

}  // namespace arbox::cli
