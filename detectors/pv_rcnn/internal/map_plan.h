#pragma once

#include <ATen/core/Tensor.h>

#include <cstdint>
#include <memory>
#include <vector>

namespace arbox::detectors::pv_rcnn::internal {

/// A convolution with its norm folded in, followed by ReLU.
struct FoldedLayer {
  at::Tensor weight;  ///< (out, in, k, k); (in, out, k, k) where transposed, and k is the stride.
  at::Tensor bias;    ///< (out)
  std::int64_t stride = 1;
};

/// The 2-D backbone for inference: oneDNN primitives for one shape of map, weights packed once,
/// maps kept in the primitives' own memory order between them. 3x3 convolutions of stride 1 go
/// through Winograd's algorithm (Lavin and Gray, CVPR 2016) where the CPU has it.
///
/// Immutable; run() may be called from several threads.
class MapPlan {
 public:
  /// `ups[i]` (transposed) follows blocks[i]. sizes: of the map, (B, C, H, W).
  MapPlan(const std::vector<std::vector<FoldedLayer>>& blocks, const std::vector<FoldedLayer>& ups,
          at::IntArrayRef sizes);
  ~MapPlan();

  /// (B, C, H, W) to (B, sum of ups, H', W'), channels last in memory.
  at::Tensor run(const at::Tensor& map) const;

  const std::vector<std::int64_t>& sizes() const { return sizes_; }

 private:
  struct Steps;

  std::vector<std::int64_t> sizes_;
  std::unique_ptr<const Steps> steps_;
};

}  // namespace arbox::detectors::pv_rcnn::internal
