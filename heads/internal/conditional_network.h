#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace arbox::heads::internal {

/// A fully connected layer in LibTorch's layout, in memory that somebody else owns.
struct LayerWeights {
  const float* weight = nullptr;  ///< (out, in), row-major.
  const float* bias = nullptr;    ///< (out).
  std::int32_t in = 0, out = 0;
};

/// The MLP of one component: inputs are features, condition, then the values before it.
struct ComponentWeights {
  std::vector<LayerWeights> layers;
  double low = 0.0, step = 1.0;

  std::int32_t bins() const { return layers.back().out; }
};

/// Objects of a batch: their features and condition side by side, (objects, width).
struct FeatureRows {
  const float* values = nullptr;
  std::int64_t objects = 0;
  std::int32_t width = 0;
};

/// Rows with different prefixes: the object and the values of the components before.
struct PrefixRows {
  std::span<const std::int32_t> objects;
  /// (objects.size(), previous): de-quantised values, row-major.
  std::span<const float> values;
};

/// Evaluates p(component | features, values before) for inference. Work on an object's features is
/// done once, whatever the number of prefixes. Not thread-safe: give each thread its own.
class ConditionalNetwork {
 public:
  ConditionalNetwork(std::span<const ComponentWeights> components, float leak, int threads);

  /// Starts on other objects.
  void set_features(const FeatureRows& features);

  /// Logits (rows, bins) of component `index`; valid until the next call.
  std::span<const float> logits(int index, const PrefixRows& rows);

 private:
  void first_layer(const ComponentWeights& component, int index, const PrefixRows& rows);

  std::span<const ComponentWeights> components_;
  float leak_;
  int threads_;
  FeatureRows features_;
  std::vector<std::vector<float>> object_parts_;  // by component, filled on first use
  std::vector<float> current_, next_;
};

/// c = a * b^T, all row-major float32: a (rows, inner) with leading dimension a_stride, b (columns,
/// inner) with b_stride, c (rows, columns).
void multiply_transposed(std::int64_t rows, std::int64_t columns, std::int64_t inner,
                         const float* a, std::int64_t a_stride, const float* b,
                         std::int64_t b_stride, float* c);

}  // namespace arbox::heads::internal
