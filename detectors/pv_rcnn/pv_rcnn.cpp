#include "arbox/detectors/pv_rcnn/pv_rcnn.h"

#include <ATen/core/grad_mode.h>

#include <sstream>

#include "arbox/base/error.h"
#include "arbox/detectors/pv_rcnn/internal/post_processing.h"

namespace arbox::detectors::pv_rcnn {
namespace {

void require_between(double value, double low, double high, const char* what) {
  if (value > low && value < high) return;
  std::ostringstream text;
  text << "PvRcnn: " << what << " must be between " << low << " and " << high << ", got " << value;
  throw InvalidArgument(text.str());
}

void require_request(const DetectionRequest& request, bool calibrated) {
  for (const double q : request.quantiles) require_between(q, 0, 1, "a quantile");
  for (const double p : request.confidences) require_between(p, 0, 1, "a confidence");
  if (!(request.score >= 0 && request.score <= 1)) {
    throw InvalidArgument("PvRcnn: the least score must be from 0 to 1, got " +
                          std::to_string(request.score));
  }
  if (!request.confidences.empty() && !calibrated) {
    throw InvalidArgument(
        "PvRcnn: confidence boxes need a calibration, and this model has none; ask for quantile "
        "boxes, or calibrate the model on scans with known boxes");
  }
}

/// Moves every box of a detection along z.
void lift(geometry::Detection& detection, double dz) {
  detection.box.center.z() += dz;
  for (auto& box : detection.quantile_boxes) box.box.center.z() += dz;
  for (auto& box : detection.confidence_boxes) box.box.center.z() += dz;
  for (auto& box : detection.samples) box.center.z() += dz;
}

}  // namespace

PvRcnn::PvRcnn(std::shared_ptr<Network> network,
               std::optional<evaluation::ConfidenceCalibration> calibration)
    : network_(std::move(network)), calibration_(std::move(calibration)) {
  if (!network_) throw InvalidArgument("PvRcnn: expected a network, got none");
  network_->eval();
}

DetectionResult PvRcnn::detect(const geometry::PointCloudView& cloud,
                               const DetectionRequest& request) const {
  require_request(request, calibration_.has_value());
  const at::NoGradGuard no_gradient;
  const PointBatch batch = make_batch({&cloud, 1}, options(), false, 0);
  DetectionResult result;
  result.dropped_points = batch.dropped_points;
  if (batch.voxels.size() == 0) return result;
  const FirstStage first = network_->first_stage(batch);
  const Proposals proposals = network_->propose(first, options().proposals);
  result.dropped_boxes = proposals.dropped_boxes;
  if (proposals.boxes.size(0) == 0) return result;
  const Keypoints keypoints = network_->keypoints(batch, first, proposals.boxes, proposals.scene);
  const SecondStage second = network_->second_stage(keypoints, proposals.boxes, proposals.scene);
  DetectionResult found = internal::to_detections(*network_, {proposals, second}, request,
                                                  calibration_ ? &*calibration_ : nullptr);
  result.dropped_boxes += found.dropped_boxes;
  result.detections = std::move(found.detections);
  const double shift = options().sensor_height.value_or(options().trained_sensor_height) -
                       options().trained_sensor_height;
  if (shift != 0) {
    for (geometry::Detection& detection : result.detections) lift(detection, -shift);
  }
  return result;
}

}  // namespace arbox::detectors::pv_rcnn
