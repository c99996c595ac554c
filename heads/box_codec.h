#pragma once

#include <ATen/core/Tensor.h>

#include <span>
#include <string>
#include <vector>

#include "arbox/heads/references.h"

namespace arbox::heads {

/// One number of a box's description, with the range that its bins cover.
struct Component {
  std::string name;
  double low = 0.0, high = 1.0;
  /// Bins are points, both ends among them: step = (high - low) / (bins - 1).
  int bins = 512;
  /// low and high are the same angle.
  bool circular = false;

  double step() const { return (high - low) / (bins - 1); }
};

/// The vectors that describe one physical box (the set B of the paper, section 3.2), padded to M.
struct ComponentSet {
  at::Tensor values;  ///< (N, M, D).
  at::Tensor mask;    ///< (N, M) bool; at least one true in every row.
};

/// Decoded sizes are held at or above this, metres: the lowest bin of a size may mean none.
inline constexpr double kLeastDecodedSize = 1e-4;

/// Boxes to and from vectors of D components relative to references. Stateless and differentiable
/// in its tensors. It owns the autoregressive order, the ranges, the bins and the set of equivalent
/// vectors; values are never clamped here, only when they are quantised.
class BoxCodec {
 public:
  virtual ~BoxCodec();

  /// The D components in autoregressive order.
  virtual std::span<const Component> components() const = 0;

  /// boxes (N, 10) -> (N, D), the canonical vector of each box.
  virtual at::Tensor encode(const at::Tensor& boxes, const References& references) const = 0;

  /// components (N, K, D) -> (N, K, 10); row n of the references serves its K vectors. Sizes are at
  /// least kLeastDecodedSize.
  virtual at::Tensor decode(const at::Tensor& components, const References& references) const = 0;

  /// boxes (N, 10) -> every vector that training supervises.
  virtual ComponentSet equivalents(const at::Tensor& boxes, const References& references) const = 0;

  /// Indices of the components that fix the size (length, width, height; all three but in codecs of
  /// objects that share some). Conditioning on a known size needs them to come first; other orders
  /// are refused there with that reason.
  virtual std::vector<int> size_components() const = 0;

  /// Whether decoded boxes turn about z alone, given references that do.
  virtual bool upright() const = 0;

  /// sizes (N, K, 3) metres -> (N, K, 3) values of size_components().
  virtual at::Tensor encode_sizes(const at::Tensor& sizes, const References& references) const = 0;
};

}  // namespace arbox::heads
