#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "arbox/heads/internal/aligned_floats.h"

namespace arbox::heads::internal {

/// A fully connected layer in LibTorch's layout, in memory that somebody else owns.
struct LayerWeights {
  const float* weight = nullptr;  ///< (out, in), row-major.
  const float* bias = nullptr;    ///< (out).
  std::int32_t in = 0, out = 0;
};

/// The MLP of one component: inputs are features, condition, then the values before it. Outputs of
/// the last layer are the logits of the bins that it can take.
struct ComponentWeights {
  std::vector<LayerWeights> layers;
  double low = 0.0, step = 1.0;
  bool circular = false;

  std::int32_t bins() const { return layers.back().out; }
};

/// A layer as the kernels of mlp_kernel.h read it.
struct PackedLayer {
  AlignedFloats weight, bias;
  std::int32_t in = 0, columns = 0;
};

/// One component: the first layer is cut into the part that sees the features and the columns of
/// the values before.
struct PackedComponent {
  PackedLayer features;
  AlignedFloats prefix;  ///< (values before, features.columns).
  std::vector<PackedLayer> rest;
  std::int32_t bins = 0;
  double low = 0.0, step = 1.0;
  bool circular = false;

  float value(std::int32_t bin) const { return static_cast<float>(low + step * bin); }
  std::int32_t columns() const { return rest.empty() ? features.columns : rest.back().columns; }
};

/// The MLPs of all components, copied once into the layout of this CPU's kernels. Immutable: any
/// number of threads may use one.
class PackedNetwork {
 public:
  /// Component i has components[0]'s inputs and i more. `leak` is the slope of the rectifiers.
  PackedNetwork(std::span<const ComponentWeights> components, float leak, int threads = 0);

  std::int32_t size() const { return static_cast<std::int32_t>(components_.size()); }
  const PackedComponent& operator[](std::int32_t i) const { return components_[i]; }
  std::int32_t feature_width() const { return feature_width_; }
  float leak() const { return leak_; }
  /// The widest layer's padded width.
  std::int32_t widest() const { return widest_; }

 private:
  std::vector<PackedComponent> components_;
  std::int32_t feature_width_ = 0, widest_ = 0;
  float leak_;
};

}  // namespace arbox::heads::internal
