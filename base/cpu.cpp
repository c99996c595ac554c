#include "arbox/base/cpu.h"

#include <cstdlib>
#include <string>

#include "arbox/base/error.h"

namespace arbox {
namespace {

SimdLevel chosen_level() {
  const SimdLevel best = best_simd_level();
  const char* forced = std::getenv("ARBOX_SIMD");
  if (forced == nullptr || *forced == '\0') return best;
  for (const SimdLevel level : {SimdLevel::kScalar, SimdLevel::kAvx2, SimdLevel::kAvx512}) {
    if (to_string(level) != forced) continue;
    if (level <= best) return level;
    throw ConfigError("ARBOX_SIMD: this CPU has no '" + std::string(forced) + "', its best is '" +
                      std::string(to_string(best)) + "'");
  }
  throw ConfigError("ARBOX_SIMD: expected scalar, avx2 or avx512, got '" + std::string(forced) +
                    "'");
}

}  // namespace

SimdLevel best_simd_level() {
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
      __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512vl")) {
    return SimdLevel::kAvx512;
  }
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) return SimdLevel::kAvx2;
#endif
  return SimdLevel::kScalar;
}

SimdLevel simd_level() {
  static const SimdLevel level = chosen_level();
  return level;
}

std::string_view to_string(SimdLevel level) {
  switch (level) {
    case SimdLevel::kScalar:
      return "scalar";
    case SimdLevel::kAvx2:
      return "avx2";
    case SimdLevel::kAvx512:
      return "avx512";
  }
  return "unknown";
}

}  // namespace arbox
