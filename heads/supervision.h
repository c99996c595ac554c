#pragma once

#include "arbox/heads/box_codec.h"

namespace arbox::heads {

/// Which of a box's equivalent vectors a loss supervises: its canonical one, the one with the least
/// loss, or all (the mean of their losses). They differ only where a codec has several vectors of
/// one box.
enum class Supervision { kCanonical, kNearest, kAll };

/// How the likelihoods of the D components become one loss.
enum class Reduction { kSum, kMean };

/// The vectors of boxes (N, 10) that are supervised, relative to references without gradient.
ComponentSet supervised_vectors(const BoxCodec& codec, const at::Tensor& boxes,
                                const References& references, Supervision supervision);

/// losses, mask (N, M) -> (N): the least for kNearest, the mean otherwise.
at::Tensor reduce_vectors(const at::Tensor& losses, const at::Tensor& mask,
                          Supervision supervision);

/// The factor of a likelihood that is summed over `components`.
inline double likelihood_scale(Reduction reduction, double weight, std::size_t components) {
  return reduction == Reduction::kMean ? weight / static_cast<double>(components) : weight;
}

}  // namespace arbox::heads
