#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "arbox/base/error.h"
#include "arbox/geometry/detection.h"
#include "arbox/geometry/known_size.h"
#include "arbox/geometry/point_cloud_view.h"

namespace arbox::detectors {

/// What a caller wants beside class, score and most likely box.
struct DetectionRequest {
  /// Quantile boxes at these q in (0, 1).
  std::vector<double> quantiles = {};
  /// Calibrated confidence boxes at these p in (0, 1).
  std::vector<double> confidences = {};
  /// Detections below this score are left out.
  double score = 0.0;
  /// Keep the box samples in each detection.
  bool samples = false;
  /// Tell the uncertainty, too, where it is a trained head's: it takes draws, which take time.
  /// Without it detections have one if something else that is asked for takes draws.
  bool uncertainty = true;
  std::uint64_t seed = 0;
  /// Threads of all that the request takes; 0 means default_threads().
  int threads = 0;
  /// The sizes that objects of some classes may have. Each detection of such a class takes the most
  /// likely one, which Detection::known_size tells; its box, quantile boxes, samples and
  /// uncertainty are those of objects of that size. Where none of the sizes is possible to the
  /// detector the detection stays as it is without them. Throws UnknownClass, and InvalidArgument
  /// for detectors that do not know how likely a size is.
  geometry::KnownSizes known_sizes = {};
};

/// A request about a class that the detector does not know.
class UnknownClass : public InvalidArgument {
 public:
  UnknownClass(const std::string& message, std::string label)
      : InvalidArgument(message), label_(std::move(label)) {}
  const std::string& label() const { return label_; }

 private:
  std::string label_;
};

struct DetectionResult {
  /// Best score first.
  std::vector<geometry::Detection> detections;
  /// Points that were left out because a coordinate was not finite.
  std::int64_t dropped_points = 0;
  /// Candidate boxes that were left out because the network gave non-finite numbers.
  std::int64_t dropped_boxes = 0;
};

/// Anything that turns a point cloud into detections. Coordinates: LiDAR frame (x forward, y left,
/// z up), metres. A const detector may be used from several threads.
class Detector {
 public:
  virtual ~Detector() = default;
  /// An empty cloud, or one without objects, gives no detections. Throws InvalidArgument for
  /// requests that are out of range or that this detector cannot answer.
  virtual DetectionResult detect(const geometry::PointCloudView& cloud,
                                 const DetectionRequest& request = {}) const = 0;
};

}  // namespace arbox::detectors
