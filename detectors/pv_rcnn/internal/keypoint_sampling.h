#pragma once

#include <ATen/core/Tensor.h>

#include <cstdint>
#include <span>
#include <vector>

#include "arbox/detectors/pv_rcnn/options.h"

namespace arbox::detectors::pv_rcnn::internal {

struct ChosenPoints {
  at::Tensor points;                 ///< (K, 3)
  std::vector<std::int64_t> counts;  ///< Of each scan.
};

/// Spreads keypoints over the points (P, 4) of each scan by furthest point sampling; over those
/// near its regions (R, 7) if the options say so. `scene` (R) int64 does not fall. A scan without
/// points, or without points near a region, gets none; one with fewer than asked repeats them.
ChosenPoints choose_keypoints(const at::Tensor& points, std::span<const std::int64_t> point_counts,
                              const at::Tensor& regions, const at::Tensor& scene,
                              const KeypointOptions& options);

/// Rows x y z of `points` (rows of four numbers) within half of a region's diagonal plus `margin`
/// of its centre; `regions` are rows of seven numbers.
std::vector<float> points_near(std::span<const float> points, std::span<const float> regions,
                               double margin);

}  // namespace arbox::detectors::pv_rcnn::internal
