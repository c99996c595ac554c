#pragma once

#include <string_view>

namespace arbox {

/// Instruction sets that have kernels of their own, weakest first.
enum class SimdLevel { kScalar, kAvx2, kAvx512 };

/// The best level that this CPU has, whatever ARBOX_SIMD says.
SimdLevel best_simd_level();

/// The level that kernels run at: the best that this CPU has, or what the environment variable
/// ARBOX_SIMD (scalar | avx2 | avx512) forces.
///
/// Read once per process. Throws ConfigError if ARBOX_SIMD is not one of the three words or names
/// a level that this CPU lacks.
SimdLevel simd_level();

/// "scalar", "avx2" or "avx512".
std::string_view to_string(SimdLevel level);

}  // namespace arbox
