#pragma once

#include <vector>

#include "arbox/detectors/pv_rcnn/options.h"
#include "arbox/sparse/layers.h"

namespace arbox::detectors::pv_rcnn::internal {

/// Convolution - batch norm - ReLU on voxels; children 0 and 1 of `parent`.
class VoxelLayer {
 public:
  VoxelLayer(torch::nn::Module& parent, std::int64_t in, std::int64_t out,
             const sparse::Kernel& kernel);
  sparse::SparseTensor forward(const sparse::SparseTensor& input) const;

 private:
  std::shared_ptr<sparse::GridConvolution> convolution_;
  std::shared_ptr<sparse::BatchNorm> norm_;
};

/// The 3-D backbone: conv_input, conv1, conv2, ..., conv_out.
class SparseBackbone : public torch::nn::Module {
 public:
  explicit SparseBackbone(const BackboneOptions& options);

  struct Output {
    std::vector<sparse::SparseTensor> levels;
    sparse::SparseTensor map;  ///< Few cells along z.
  };
  Output forward(const sparse::SparseTensor& voxels) const;

 private:
  std::vector<VoxelLayer> input_;
  std::vector<std::vector<VoxelLayer>> levels_;
  std::vector<VoxelLayer> output_;
};

}  // namespace arbox::detectors::pv_rcnn::internal
