#pragma once

#include <ATen/core/ivalue.h>  // before nn headers: clang cannot parse them otherwise

#include <torch/nn/module.h>

#include <cstdint>
#include <map>
#include <memory>
#include <string>

#include "arbox/heads/box_codec.h"
#include "arbox/heads/box_distribution.h"
#include "arbox/heads/references.h"

namespace arbox::heads {

/// What a head is built for.
struct HeadContext {
  std::int64_t features = 0;   ///< C.
  std::int64_t condition = 0;  ///< E; 0 without condition.
  std::shared_ptr<const BoxCodec> codec;
};

/// What a detector hands to a head for N objects.
struct HeadInput {
  at::Tensor features;  ///< (N, C) float.
  References references;
  at::Tensor condition;  ///< (N, E): a pointwise prediction and the like, or undefined.
  /// Random numbers of losses that draw samples: a training loop passes its step.
  std::uint64_t seed = 0;
  /// (N) int64, names of the objects for random numbers; their rows if undefined.
  at::Tensor object_ids = {};

  std::int64_t count() const { return features.defined() ? features.size(0) : 0; }
  HeadInput select(const at::Tensor& index) const;

  /// The random numbers of the objects.
  Streams streams() const;

  /// (N, C + E): features and condition side by side.
  at::Tensor joined() const;

  /// Throws InvalidArgument, naming `where`, the tensor and both shapes, for what does not fit the
  /// context, and NumericalError that names the tensor and the row of a non-finite number.
  void require_valid(const HeadContext& context, const char* where) const;
};

/// Throws InvalidArgument unless `boxes` is (count, 10), NumericalError, naming the row, for
/// numbers that are not finite and sizes that are not above zero.
void require_targets(const at::Tensor& boxes, std::int64_t count, const char* where);

/// Losses per object: the detector weighs them and reduces.
struct HeadLoss {
  at::Tensor per_object;                    ///< (N), with gradient.
  std::map<std::string, at::Tensor> terms;  ///< Named parts, (N) each, for logs.
};

/// The last step of a detector: features and references to a distribution over boxes.
class BoxHead : public torch::nn::Module {
 public:
  ~BoxHead() override;

  /// Cheap: the distribution does its work when asked, without gradient, with the parameters as
  /// they are then. Non-finite features throw NumericalError that names the tensor; no objects give
  /// an empty distribution.
  virtual std::unique_ptr<BoxDistribution> forward(const HeadInput& input) = 0;

  /// Loss of the target boxes (N, 10) of each object; no objects give no losses. The loss of an
  /// object does not depend on the others. Throws as forward, and as require_targets.
  virtual HeadLoss loss(const HeadInput& input, const at::Tensor& target_boxes) = 0;
};

}  // namespace arbox::heads
