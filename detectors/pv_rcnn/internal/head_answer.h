#pragma once

#include <ATen/core/Tensor.h>

#include <cstdint>
#include <vector>

#include "arbox/detectors/detector.h"
#include "arbox/detectors/pv_rcnn/options.h"
#include "arbox/geometry/known_size.h"
#include "arbox/heads/box_head.h"
#include "arbox/heads/distribution_boxes.h"

namespace arbox::detectors::pv_rcnn::internal {

/// (N) of whole numbers.
at::Tensor index_tensor(const std::vector<std::int64_t>& index);

/// What a head says of N candidates.
struct HeadAnswer {
  at::Tensor boxes;        // (N, 7)
  at::Tensor log_density;  // (N) or undefined
  heads::DistributionBoxes summary;
  /// By candidate, null without one; empty if none is asked for.
  std::vector<const geometry::KnownSize*> known_sizes;
  /// By candidate: draws of objects of unknown size, if `summary` has others.
  std::vector<std::vector<geometry::Box>> free_samples;
};

/// Asks a head for what the request and PostOptions want. `labels`: class of each candidate;
/// `pointwise` (N, 7): their pointwise boxes. The answer points into the request's known sizes.
HeadAnswer ask(heads::BoxHead& head, const heads::HeadInput& input, const std::vector<int>& labels,
               const at::Tensor& pointwise, const DetectionRequest& request,
               const Options& options);

}  // namespace arbox::detectors::pv_rcnn::internal
