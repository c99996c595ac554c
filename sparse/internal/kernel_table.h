#pragma once

#include "arbox/base/cpu.h"
#include "arbox/sparse/internal/convolution_kernel.h"

namespace arbox::sparse::internal {

/// The kernels of one instruction set.
struct KernelTable {
  std::int32_t (*lanes)();
  void (*pack_weight)(const WeightMatrix&, std::int32_t, float*);
  void (*accumulate)(const PairRun&);
  void (*accumulate_weight_gradient)(const WeightGradientRun&);

  /// Channels rounded up to whole vectors.
  std::int32_t padded(std::int32_t channels) const {
    return (channels + lanes() - 1) / lanes() * lanes();
  }
};

/// The kernels of simd_level().
inline KernelTable kernel_table() {
  switch (simd_level()) {
    case SimdLevel::kAvx512:
      return {avx512::lanes, avx512::pack_weight, avx512::accumulate,
              avx512::accumulate_weight_gradient};
    case SimdLevel::kAvx2:
      return {avx2::lanes, avx2::pack_weight, avx2::accumulate, avx2::accumulate_weight_gradient};
    case SimdLevel::kScalar:
      break;
  }
  return {scalar::lanes, scalar::pack_weight, scalar::accumulate,
          scalar::accumulate_weight_gradient};
}

}  // namespace arbox::sparse::internal
