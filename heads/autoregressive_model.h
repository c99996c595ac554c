#pragma once

#include <ATen/core/Tensor.h>

#include <cstdint>
#include <memory>
#include <mutex>
#include <vector>

#include "arbox/heads/box_codec.h"
#include "arbox/heads/quantizer.h"

namespace arbox::heads {

namespace internal {
class PackedNetwork;
}

/// The conditionals of an autoregressive head, as its distributions evaluate them: one MLP a
/// component, frozen and copied into the layout of this CPU's kernels when first used. Safe to use
/// from several threads.
class AutoregressiveModel {
 public:
  /// Weight (out, in) and bias (out).
  struct Layer {
    at::Tensor weight, bias;
  };
  /// The MLP of one component.
  using Layers = std::vector<Layer>;

  /// `leak` is the slope of the rectifiers between layers; threads = 0 means default_threads().
  AutoregressiveModel(std::shared_ptr<const BoxCodec> codec, CircularEnds circular_ends,
                      std::vector<Layers> components, double leak, int threads);
  ~AutoregressiveModel();

  const BoxCodec& codec() const { return *codec_; }
  CircularEnds circular_ends() const { return circular_ends_; }
  int threads() const { return threads_; }

  /// Copies the parameters at the first call.
  const internal::PackedNetwork& network() const;

  /// Whether this was made from these very parameters, and none of them has been written since (as
  /// far as LibTorch knows: writes through raw pointers it does not see).
  bool is_of(const std::vector<Layers>& components) const;

 private:
  std::shared_ptr<const BoxCodec> codec_;
  CircularEnds circular_ends_;
  std::vector<Layers> components_;
  std::vector<std::int64_t> versions_;
  double leak_;
  int threads_;
  mutable std::once_flag once_;
  mutable std::unique_ptr<const internal::PackedNetwork> network_;
};

}  // namespace arbox::heads
