#pragma once

#include <ATen/core/Tensor.h>

#include <cstdint>
#include <span>

#include "arbox/heads/box_codec.h"
#include "arbox/heads/quantizer.h"

/// \file
/// What heads that live in the codec's space share.

namespace arbox::heads::internal {

/// Bins that a component can take: without the last one where circular ends are merged.
std::int64_t usable_bins(const Component& component, CircularEnds ends);

/// (bins) values of the bins.
at::Tensor bin_values(const Component& component, std::int64_t bins, at::ScalarType type);

/// (..., bins) probabilities -> (...) expected value; for circular components the direction of the
/// mean of unit vectors, in [low, high).
at::Tensor expected_value(const at::Tensor& probability, const Component& component);

/// (..., D) differences of component values, wrapped into half a period where circular.
at::Tensor component_difference(const at::Tensor& first, const at::Tensor& second,
                                std::span<const Component> components);

/// (..., K, D) values -> (..., D): means, circular where the component is.
at::Tensor mean_of_values(const at::Tensor& values, std::span<const Component> components);

/// (D) middle and half of the range of each component.
at::Tensor middles(std::span<const Component> components, at::ScalarType type);
at::Tensor half_ranges(std::span<const Component> components, at::ScalarType type);

/// bins (N, M, D), mask (N, M) -> (N, M) bool: the mask without vectors that repeat an earlier one.
at::Tensor distinct_vectors(const at::Tensor& bins, const at::Tensor& mask);

/// values, mask (N, M) -> (N): mean of the masked values.
at::Tensor masked_mean(const at::Tensor& values, const at::Tensor& mask);
/// (N): least of the masked values.
at::Tensor masked_least(const at::Tensor& values, const at::Tensor& mask);
/// (N): log of the sum of the exponentials of the masked values; -infinity without any.
at::Tensor masked_log_sum(const at::Tensor& values, const at::Tensor& mask);

/// values (N, K, D) with the size components replaced by `sizes` (N, 3) component values.
at::Tensor with_sizes(const at::Tensor& values, const BoxCodec& codec, const at::Tensor& sizes);

/// mask (N, M) of the vectors (N, M, D) whose size components are within half a bin of `sizes`.
at::Tensor of_sizes(const at::Tensor& values, const at::Tensor& mask, const BoxCodec& codec,
                    const at::Tensor& sizes);

/// sizes (N, 3) metres -> (N, 3) values of the size components.
at::Tensor size_values(const at::Tensor& sizes, const BoxCodec& codec,
                       const References& references);

}  // namespace arbox::heads::internal
