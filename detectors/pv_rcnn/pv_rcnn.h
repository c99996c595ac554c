#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "arbox/detectors/detector.h"
#include "arbox/detectors/pv_rcnn/network.h"
#include "arbox/evaluation/confidence_calibration.h"

namespace arbox::detectors::pv_rcnn {

/// PV-RCNN as a detector: proposals, regions, suppression, and the head on what is left.
///
/// Each detection has the box that PostOptions::box names, its class and score (sigmoid of the
/// confidence) and, where the head (PostOptions::head) has a likelihood, log density, uncertainty
/// (from PostOptions::samples draws) and quantile boxes as asked for. Heads without one (pointwise)
/// give their one box for every quantile, and no uncertainty. Confidence boxes need a calibration.
///
/// Known sizes (DetectionRequest::known_sizes) need a head that tells how likely a size is
/// (autoregressive with the size first, gaussian, discrete). They are length, width and height, and
/// are compared by PostOptions::known_sizes; pointwise boxes give way to the most likely ones of
/// that size. Confidence boxes stay those of unknown size, which the
/// calibration is of; the log density is the head's, of the size and the rest.
///
/// Input, and what becomes of it:
/// - no points, or none in range: no detections;
/// - points that are not finite: left out and counted;
/// - any number of points: beyond VoxelOptions::max_points, max_points_per_voxel and max_voxels
///   they are thinned, so that time and memory are bounded;
/// - intensity in 0..255 or 0..65535: divided (make_batch); none: taken as 0, which costs accuracy;
/// - a sensor at another height: say Options::sensor_height, boxes come in the cloud's own frame;
/// - another number of beams: accepted; accuracy is what training on other densities gives.
/// Boxes whose numbers are not finite are left out and counted in DetectionResult::dropped_boxes.
///
/// Const, safe to use from several threads. Same cloud, network, seed and CPU: same bytes.
class PvRcnn : public Detector {
 public:
  /// Puts the network into eval mode; it must not be trained while the detector is in use.
  explicit PvRcnn(std::shared_ptr<Network> network,
                  std::optional<evaluation::ConfidenceCalibration> calibration = {});

  /// Throws InvalidArgument for a request out of range, for confidences without a calibration or of
  /// another head than the first, which is the one that is calibrated, and for known sizes of an
  /// unknown class or of a head that cannot use them.
  DetectionResult detect(const geometry::PointCloudView& cloud,
                         const DetectionRequest& request = {}) const override;
  /// What each of Network::heads() makes of the same proposals, in their order.
  std::vector<DetectionResult> detect_with_every_head(const geometry::PointCloudView& cloud,
                                                      const DetectionRequest& request = {}) const;

  const Options& options() const { return network_->options(); }
  const Network& network() const { return *network_; }

 private:
  std::vector<DetectionResult> detect_with(std::span<heads::BoxHead* const> heads,
                                           const geometry::PointCloudView& cloud,
                                           const DetectionRequest& request) const;

  std::shared_ptr<Network> network_;
  std::optional<evaluation::ConfidenceCalibration> calibration_;
};

}  // namespace arbox::detectors::pv_rcnn
