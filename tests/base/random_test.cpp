#include "arbox/base/random.h"

#include <gtest/gtest.h>

#include <cmath>

namespace {

using arbox::philox;
using arbox::RandomStream;

// Known answers of the Random123 distribution (kat_vectors, philox4x32 10).
TEST(Philox, GivesThePublishedKnownAnswers) {
  EXPECT_EQ(philox({0, 0, 0, 0}, {0, 0}),
            (std::array<std::uint32_t, 4>{0x6627e8d5, 0xe169c58d, 0xbc57ac4c, 0x9b00dbd8}));
  const std::uint32_t ones = 0xffffffff;
  EXPECT_EQ(philox({ones, ones, ones, ones}, {ones, ones}),
            (std::array<std::uint32_t, 4>{0x408f276d, 0x41c83b0e, 0xa20bc7c6, 0x6d5451fd}));
  EXPECT_EQ(philox({0x243f6a88, 0x85a308d3, 0x13198a2e, 0x03707344}, {0xa4093822, 0x299f31d0}),
            (std::array<std::uint32_t, 4>{0xd16cfe09, 0x94fdcceb, 0x5001e420, 0x24126ea1}));
}

TEST(RandomStream, DrawDependsOnSeedObjectPurposeAndIndexAlone) {
  const RandomStream stream(1, 2, 3);
  const double later = stream.uniform(1000);
  for (std::uint32_t i = 0; i < 1000; ++i) stream.uniform(i);
  EXPECT_EQ(stream.uniform(1000), later);
  EXPECT_NE(RandomStream(2, 2, 3).uniform(1000), later);
  EXPECT_NE(RandomStream(1, 3, 3).uniform(1000), later);
  EXPECT_NE(RandomStream(1, 2, 4).uniform(1000), later);
}

TEST(RandomStream, MomentsOfUniformAndNormalAreRight) {
  const RandomStream stream(7, 0, 0);
  const int draws = 100000;
  double sum = 0, normal_sum = 0, normal_squares = 0;
  for (int i = 0; i < draws; ++i) {
    const double value = stream.uniform(i);
    ASSERT_GE(value, 0.0);
    ASSERT_LT(value, 1.0);
    sum += value;
    const double normal = stream.normal(i);
    normal_sum += normal;
    normal_squares += normal * normal;
  }
  EXPECT_NEAR(sum / draws, 0.5, 0.005);
  EXPECT_NEAR(normal_sum / draws, 0.0, 0.02);
  EXPECT_NEAR(normal_squares / draws, 1.0, 0.03);
}

TEST(RandomStream, BelowCoversItsRangeEvenly) {
  const RandomStream stream(7, 0, 0);
  std::array<int, 5> counts{};
  for (int i = 0; i < 50000; ++i) ++counts.at(stream.below(i, 5));
  for (const int count : counts) EXPECT_NEAR(count, 10000, 500);
}

}  // namespace
