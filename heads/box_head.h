#pragma once

#include <ATen/core/ivalue.h>  // before nn headers: clang cannot parse them otherwise

#include <torch/nn/module.h>

#include <map>
#include <memory>
#include <string>

#include "arbox/heads/box_codec.h"
#include "arbox/heads/box_distribution.h"
#include "arbox/heads/references.h"

namespace arbox::heads {

/// What a detector hands to a head for N objects.
struct HeadInput {
  at::Tensor features;  ///< (N, C) float.
  References references;
  at::Tensor condition;  ///< (N, E): a pointwise prediction and the like, or undefined.

  std::int64_t count() const { return features.defined() ? features.size(0) : 0; }
  HeadInput select(const at::Tensor& index) const;
};

/// Losses per object: the detector weighs them and reduces.
struct HeadLoss {
  at::Tensor per_object;                    ///< (N), with gradient.
  std::map<std::string, at::Tensor> terms;  ///< Named parts, (N) each, for logs.
};

/// What a head is built for.
struct HeadContext {
  std::int64_t features = 0;   ///< C.
  std::int64_t condition = 0;  ///< E; 0 without condition.
  std::shared_ptr<const BoxCodec> codec;
};

/// The last step of a detector: features and references to a distribution over boxes.
class BoxHead : public torch::nn::Module {
 public:
  ~BoxHead() override;

  /// Cheap: the distribution does its work when asked. Non-finite features throw NumericalError
  /// that names the tensor; no objects give an empty distribution.
  virtual std::unique_ptr<BoxDistribution> forward(const HeadInput& input) = 0;

  /// Loss of the target boxes (N, 10) of each object.
  virtual HeadLoss loss(const HeadInput& input, const at::Tensor& target_boxes) = 0;
};

}  // namespace arbox::heads
