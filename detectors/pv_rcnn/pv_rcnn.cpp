#include "arbox/detectors/pv_rcnn/pv_rcnn.h"

#include <ATen/Parallel.h>
#include <ATen/core/grad_mode.h>

#include <algorithm>
#include <sstream>

#include "arbox/base/error.h"
#include "arbox/base/names.h"
#include "arbox/base/parallel.h"
#include "arbox/detectors/pv_rcnn/box_coding.h"
#include "arbox/detectors/pv_rcnn/internal/post_processing.h"
#include "arbox/heads/conditioning.h"

namespace arbox::detectors::pv_rcnn {
namespace {

void require_between(double value, double low, double high, const char* what) {
  if (value > low && value < high) return;
  std::ostringstream text;
  text << "PvRcnn: " << what << " must be between " << low << " and " << high << ", got " << value;
  throw InvalidArgument(text.str());
}

void require_calibration(bool present, bool first_head) {
  if (!present) {
    throw InvalidArgument(
        "PvRcnn: confidence boxes need a calibration, and this model has none; ask for quantile "
        "boxes, or calibrate the model on scans with known boxes");
  }
  if (!first_head) {
    throw InvalidArgument(
        "PvRcnn: this model's calibration is of its first head, and another one was asked for "
        "confidence boxes; ask for quantile boxes, or use the first head");
  }
}

void require_request(const DetectionRequest& request) {
  for (const double q : request.quantiles) require_between(q, 0, 1, "a quantile");
  for (const double p : request.confidences) require_between(p, 0, 1, "a confidence");
  if (!(request.score >= 0 && request.score <= 1)) {
    throw InvalidArgument("PvRcnn: the least score must be from 0 to 1, got " +
                          std::to_string(request.score));
  }
}

void require_sizes(const std::string& label, const std::vector<geometry::KnownSize>& sizes) {
  if (sizes.empty()) {
    throw InvalidArgument("PvRcnn: known sizes of class '" + label +
                          "': expected at least one, got none");
  }
  for (const auto& [name, size] : sizes) {
    if (size.allFinite() && (size.array() > 0).all()) continue;
    std::ostringstream text;
    text << "PvRcnn: known sizes of class '" << label
         << "': expected finite extents above zero, got " << size.transpose();
    throw InvalidArgument(text.str());
  }
}

/// Why a head of the network does not know how likely sizes are; empty if it does.
std::string why_not_conditioned(const Network& network, heads::BoxHead& head) {
  return heads::why_not_conditioned(*head.forward(network.no_head_input()));
}

void require_known_sizes(const geometry::KnownSizes& known, const Network& network,
                         std::span<heads::BoxHead* const> heads) {
  const std::vector<std::string>& classes = network.options().classes;
  for (const auto& [label, sizes] : known) {
    if (std::find(classes.begin(), classes.end(), label) == classes.end()) {
      throw UnknownClass("PvRcnn: known sizes of " + unknown_name_text("class", label, classes),
                         label);
    }
    require_sizes(label, sizes);
  }
  if (known.empty()) return;
  for (heads::BoxHead* const head : heads) {
    const std::string why = why_not_conditioned(network, *head);
    if (why.empty()) continue;
    std::vector<std::string> able;
    for (const auto& [name, other] : network.heads()) {
      if (why_not_conditioned(network, *other).empty()) able.push_back(name);
    }
    throw InvalidArgument("PvRcnn: known sizes cannot be used: " + why + "; " +
                          (able.empty() ? "none of this model's heads does; an autoregressive head "
                                          "that predicts the size first, gaussian or discrete would"
                                        : "of this model's heads these can: " + join(able, ", ")));
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
  heads::BoxHead* const head = &network_->head();
  return detect_with({&head, 1}, cloud, request).front();
}

std::vector<DetectionResult> PvRcnn::detect_with_every_head(const geometry::PointCloudView& cloud,
                                                            const DetectionRequest& request) const {
  std::vector<heads::BoxHead*> heads;
  for (const auto& [name, head] : network_->heads()) heads.push_back(head.get());
  return detect_with(heads, cloud, request);
}

std::vector<DetectionResult> PvRcnn::detect_with(std::span<heads::BoxHead* const> heads,
                                                 const geometry::PointCloudView& cloud,
                                                 const DetectionRequest& request) const {
  require_request(request);
  if (!request.confidences.empty()) {
    const heads::BoxHead* const first = network_->heads().front().second.get();
    require_calibration(
        calibration_.has_value(),
        std::all_of(heads.begin(), heads.end(), [&](const auto* head) { return head == first; }));
  }
  const at::NoGradGuard no_gradient;
  at::get_num_threads();  // LibTorch chooses its threads when first asked, which would undo ours.
  const ThreadScope threads(request.threads);
  require_known_sizes(request.known_sizes, *network_, heads);
  const PointBatch batch = make_batch({&cloud, 1}, options(), false, 0);
  std::vector<DetectionResult> results(heads.size());
  for (DetectionResult& result : results) result.dropped_points = batch.dropped_points;
  if (batch.voxels.size() == 0) return results;
  const FirstStage first = network_->first_stage(batch);
  const Proposals proposals = network_->propose(first, options().proposals);
  for (DetectionResult& result : results) result.dropped_boxes = proposals.dropped_boxes;
  if (proposals.boxes.size(0) == 0) return results;
  const Keypoints keypoints = network_->keypoints(batch, first, proposals.boxes, proposals.scene);
  const SecondStage second = network_->second_stage(keypoints, proposals.boxes, proposals.scene);
  const double shift = options().sensor_height.value_or(options().trained_sensor_height) -
                       options().trained_sensor_height;
  for (std::size_t i = 0; i < heads.size(); ++i) {
    DetectionResult found =
        internal::to_detections(*network_, *heads[i], {proposals, second}, request,
                                calibration_ ? &*calibration_ : nullptr);
    results[i].dropped_boxes += found.dropped_boxes;
    results[i].detections = std::move(found.detections);
    if (shift == 0) continue;
    for (geometry::Detection& detection : results[i].detections) lift(detection, -shift);
  }
  return results;
}

}  // namespace arbox::detectors::pv_rcnn
