#include "arbox/base/blas.h"

#include <dlfcn.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>

#include "arbox/base/cpu.h"

namespace {

using arbox::best_simd_level;
using arbox::blas_kernels;
using arbox::mend_blas_kernels;
using arbox::SimdLevel;

class BlasKernelsDeathTest : public ::testing::Test {
 protected:
  void SetUp() override { GTEST_FLAG_SET(death_test_style, "threadsafe"); }
};

[[noreturn]] void mend_without_openblas() {
  const std::string before = blas_kernels();
  std::fprintf(stderr, "'%s' %s\n", before.c_str(), mend_blas_kernels() ? "became" : "stayed");
  std::exit(0);
}

TEST_F(BlasKernelsDeathTest, AreNoneWithoutOpenBlas) {
  EXPECT_EXIT(mend_without_openblas(), ::testing::ExitedWithCode(0), "'' stayed");
}

// Elsewhere OpenBLAS has no kernels of these names.
#if defined(__x86_64__)

constexpr const char* kVariable = "OPENBLAS_CORETYPE";
constexpr int kSize = 37;
using Matrix = std::array<float, std::size_t{kSize} * kSize>;
using Multiply = void(int order, int transposed_a, int transposed_b, int m, int n, int k,
                      float alpha, const float* a, int stride_a, const float* b, int stride_b,
                      float beta, float* c, int stride_c);

void* load_openblas() { return ::dlopen("libopenblas.so.0", RTLD_NOW | RTLD_LOCAL); }

Matrix waves(float frequency) {
  Matrix values;
  for (std::size_t i = 0; i < values.size(); ++i) {
    values[i] = std::sin(frequency * static_cast<float>(i));
  }
  return values;
}

/// The largest difference between OpenBLAS's product of two matrices and sums in double precision.
double product_error(void* openblas) {
  constexpr int kRowMajor = 101;
  constexpr int kPlain = 111;
  const Matrix a = waves(0.7F);
  const Matrix b = waves(1.3F);
  Matrix product = {};
  reinterpret_cast<Multiply*>(::dlsym(openblas, "cblas_sgemm"))(
      kRowMajor, kPlain, kPlain, kSize, kSize, kSize, 1, a.data(), kSize, b.data(), kSize, 0,
      product.data(), kSize);
  double worst = 0;
  for (int row = 0; row < kSize; ++row) {
    for (int column = 0; column < kSize; ++column) {
      double sum = 0;
      for (int k = 0; k < kSize; ++k) sum += double{a[row * kSize + k]} * b[k * kSize + column];
      worst = std::max(worst, std::abs(sum - product[row * kSize + column]));
    }
  }
  return worst;
}

// OpenBLAS is loaded once per process: each case asks in a process of its own. What it would choose
// on a CPU that it does not know is forced on it, and the variable gone again.
[[noreturn]] void mend_what_chose(const char* kernels, bool keep_variable) {
  ::setenv(kVariable, kernels, 1);
  void* const openblas = load_openblas();
  if (!keep_variable) ::unsetenv(kVariable);
  const std::string before = blas_kernels();
  const bool mended = mend_blas_kernels();
  std::fprintf(stderr, "%s %s %s, products %s, variable %s\n", before.c_str(),
               mended ? "became" : "stayed", blas_kernels().c_str(),
               product_error(openblas) < 1e-4 ? "right" : "wrong",
               std::getenv(kVariable) != nullptr ? "set" : "unset");
  std::exit(0);
}

TEST_F(BlasKernelsDeathTest, BecomeThoseOfTheCpuWhereThePentium4sWereChosen) {
  const std::string expected = best_simd_level() == SimdLevel::kAvx512 ? "became SkylakeX"
                               : best_simd_level() == SimdLevel::kAvx2 ? "became Haswell"
                                                                       : "stayed Prescott";
  EXPECT_EXIT(mend_what_chose("Prescott", false), ::testing::ExitedWithCode(0),
              "Prescott " + expected + ", products right, variable unset");
}

TEST_F(BlasKernelsDeathTest, StayWhereTheVariableChoseThem) {
  EXPECT_EXIT(mend_what_chose("Prescott", true), ::testing::ExitedWithCode(0),
              "Prescott stayed Prescott, products right, variable set");
}

TEST_F(BlasKernelsDeathTest, StayWhereOpenBlasKnewTheCpu) {
  EXPECT_EXIT(mend_what_chose("Nehalem", false), ::testing::ExitedWithCode(0),
              "Nehalem stayed Nehalem, products right, variable unset");
}

#endif

}  // namespace
