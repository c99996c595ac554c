#pragma once

#include <ATen/TensorOperators.h>
#include <ATen/core/Tensor.h>
#include <gtest/gtest.h>

#include <algorithm>

/// Expects tensors of one shape that differ by at most `tolerance` times the largest entry.
inline void expect_close(const at::Tensor& got, const at::Tensor& expected,
                         double tolerance = 1e-5) {
  ASSERT_EQ(got.sizes(), expected.sizes());
  if (got.numel() == 0) return;
  const double scale = std::max(1e-30, expected.abs().max().item<double>());
  EXPECT_LE((got - expected).abs().max().item<double>(), tolerance * scale);
}
