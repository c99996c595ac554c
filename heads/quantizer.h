#pragma once

#include <ATen/core/Tensor.h>

#include <span>

#include "arbox/heads/box_codec.h"

/// \file
/// Values of components to bins and back (paper, section 3.1). Bins are points: bin 0 is `low`, the
/// last one is `high`.

namespace arbox::heads {

/// The two end bins of a circular component are the same angle: merged into bin 0 (the last bin is
/// never a label), or kept apart as in weights trained that way.
enum class CircularEnds { kMerged, kDistinct };

/// values (..., D) -> bins (..., D) int64: nearest bin (halves to even), clamped to the ends.
at::Tensor quantize(const at::Tensor& values, std::span<const Component> components,
                    CircularEnds ends = CircularEnds::kMerged);

/// bins (..., D) -> values (..., D) float32.
at::Tensor dequantize(const at::Tensor& bins, std::span<const Component> components);

/// (..., D) bool: the value lies more than half a step outside of its range. Circular components
/// never do.
at::Tensor overflows(const at::Tensor& values, std::span<const Component> components);

}  // namespace arbox::heads
