#pragma once

#include <memory>
#include <vector>

#include "arbox/detectors/pv_rcnn/internal/row_layer.h"
#include "arbox/detectors/pv_rcnn/network.h"
#include "arbox/sparse/set_abstraction.h"

namespace arbox::detectors::pv_rcnn::internal {

/// RoI grid pooling, shared layers, confidence and the pointwise branch.
class RegionHead : public torch::nn::Module {
 public:
  RegionHead(const RegionOptions& options, std::int64_t keypoint_channels);
  SecondStage forward(const Keypoints& keypoints, const at::Tensor& regions,
                      const at::Tensor& scene);

 private:
  at::Tensor pooled(const Keypoints& keypoints, const at::Tensor& regions, const at::Tensor& scene);

  std::int64_t grid_;
  std::shared_ptr<sparse::SetAbstraction> pooling_;
  std::vector<RowNetwork> networks_;  // shared, confidence, residuals
};

}  // namespace arbox::detectors::pv_rcnn::internal
