#pragma once

#include <vector>

#include "arbox/detectors/detector.h"
#include "arbox/detectors/pv_rcnn/network.h"
#include "arbox/evaluation/confidence_calibration.h"

namespace arbox::detectors::pv_rcnn::internal {

/// What the second stage says of the regions of one scan.
struct RegionResults {
  const Proposals& proposals;
  const SecondStage& second;
};

/// Scores, suppression, and boxes from one of the network's heads. Throws InvalidArgument for
/// confidences without a calibration.
DetectionResult to_detections(const Network& network, heads::BoxHead& head,
                              const RegionResults& results, const DetectionRequest& request,
                              const evaluation::ConfidenceCalibration* calibration);

}  // namespace arbox::detectors::pv_rcnn::internal
