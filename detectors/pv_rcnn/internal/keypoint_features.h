#pragma once

#include <memory>
#include <vector>

#include "arbox/detectors/pv_rcnn/internal/keypoint_sampling.h"
#include "arbox/detectors/pv_rcnn/internal/row_layer.h"
#include "arbox/detectors/pv_rcnn/network.h"
#include "arbox/sparse/set_abstraction.h"

namespace arbox::detectors::pv_rcnn::internal {

/// Voxel set abstraction: what keypoints gather from the map, the points and the voxels.
class KeypointFeatures : public torch::nn::Module {
 public:
  /// map_channels: of what FirstStage::map or cells holds.
  KeypointFeatures(const Options& options, std::int64_t map_channels);

  /// (K, gathered_channels()): map, points, levels side by side.
  at::Tensor gather(const ChosenPoints& keypoints, const PointBatch& batch,
                    const FirstStage& first) const;
  /// (K, gathered_channels()) to (K, fused).
  at::Tensor fuse(const at::Tensor& gathered) const { return fusion_.front().forward(gathered); }

  std::int64_t gathered_channels() const { return channels_; }

 private:
  at::Tensor from_map(const ChosenPoints& keypoints, const FirstStage& first) const;
  at::Tensor from_level(std::size_t source, const ChosenPoints& keypoints,
                        const sparse::SparseTensor& level) const;

  Options options_;
  std::int64_t channels_ = 0;
  std::shared_ptr<sparse::SetAbstraction> points_;
  std::vector<std::shared_ptr<sparse::SetAbstraction>> levels_;
  std::vector<std::size_t> level_numbers_;
  std::vector<RowLayer> fusion_;
};

/// Tells keypoints on objects from others.
class KeypointWeighting : public torch::nn::Module {
 public:
  KeypointWeighting(const KeypointOptions& options, std::int64_t in_channels);
  /// (K) logits.
  at::Tensor forward(const at::Tensor& gathered) const;

 private:
  std::vector<RowNetwork> network_;
};

}  // namespace arbox::detectors::pv_rcnn::internal
