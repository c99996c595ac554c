#include "arbox/base/cpu.h"

#include <gtest/gtest.h>

#include <cstdlib>

#include "arbox/base/error.h"

namespace {

using arbox::simd_level;
using arbox::SimdLevel;
using arbox::to_string;

// The level is read once per process: each case asks in a process of its own.
[[noreturn]] void ask(const char* forced) {
  ::setenv("ARBOX_SIMD", forced, 1);
  try {
    std::fprintf(stderr, "level %s\n", std::string(to_string(simd_level())).c_str());
  } catch (const arbox::ConfigError& error) {
    std::fprintf(stderr, "refused %s\n", error.what());
  }
  std::exit(0);
}

class SimdLevelDeathTest : public ::testing::Test {
 protected:
  void SetUp() override { GTEST_FLAG_SET(death_test_style, "threadsafe"); }
};

TEST_F(SimdLevelDeathTest, IsWhatTheVariableForces) {
  EXPECT_EXIT(ask("scalar"), ::testing::ExitedWithCode(0), "level scalar");
}

TEST_F(SimdLevelDeathTest, EmptyVariableMeansTheBest) {
  EXPECT_EXIT(ask(""), ::testing::ExitedWithCode(0), "level (scalar|avx2|avx512)");
}

TEST_F(SimdLevelDeathTest, RefusesAWrongWord) {
  EXPECT_EXIT(ask("sse9"), ::testing::ExitedWithCode(0),
              "refused ARBOX_SIMD: expected scalar, avx2 or avx512, got 'sse9'");
  EXPECT_EXIT(ask("AVX2"), ::testing::ExitedWithCode(0), "refused ARBOX_SIMD");
}

TEST_F(SimdLevelDeathTest, GivesOrRefusesALevelAsThisCpuHasIt) {
#if defined(__x86_64__)
  const bool has = __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
                   __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512vl");
#else
  const bool has = false;
#endif
  EXPECT_EXIT(ask("avx512"), ::testing::ExitedWithCode(0),
              has ? "level avx512" : "refused ARBOX_SIMD: this CPU has no 'avx512', its best is");
}

TEST(SimdLevel, NamesAreThoseOfTheVariable) {
  EXPECT_EQ(to_string(SimdLevel::kScalar), "scalar");
  EXPECT_EQ(to_string(SimdLevel::kAvx2), "avx2");
  EXPECT_EQ(to_string(SimdLevel::kAvx512), "avx512");
}

}  // namespace
