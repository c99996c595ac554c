#include "arbox/training/scene_order.h"

#include <gtest/gtest.h>

#include <atomic>
#include <set>
#include <stdexcept>

#include "arbox/base/error.h"
#include "arbox/training/ordered_prefetch.h"

namespace {

using namespace arbox;
using namespace arbox::training;

std::vector<std::int64_t> places(SceneOrder& order, std::int64_t begin, std::int64_t end) {
  std::vector<std::int64_t> result;
  for (std::int64_t place = begin; place < end; ++place) result.push_back(order.at(place));
  return result;
}

TEST(SceneOrder, EachEpochVisitsEverySceneOnceInAnotherOrder) {
  SceneOrder order(5, 100);
  const auto first = places(order, 0, 100), second = places(order, 100, 200);
  EXPECT_EQ(std::set(first.begin(), first.end()).size(), 100u);
  EXPECT_EQ(std::set(second.begin(), second.end()).size(), 100u);
  EXPECT_NE(first, second);
  EXPECT_EQ(places(order, 0, 100), first);
  SceneOrder other(6, 100);
  EXPECT_NE(places(other, 0, 100), first);
}

TEST(SceneOrder, EveryPlaceIsEquallyLikely) {
  constexpr int kScenes = 5, kSeeds = 4000;
  std::vector<int> counts(kScenes);
  for (int seed = 0; seed < kSeeds; ++seed) {
    ++counts[static_cast<std::size_t>(SceneOrder(static_cast<std::uint64_t>(seed), kScenes).at(2))];
  }
  for (const int count : counts) EXPECT_NEAR(count, kSeeds / kScenes, 5 * 25.3);
}

TEST(SceneOrder, OneSceneAndNone) {
  SceneOrder order(1, 1);
  EXPECT_EQ(order.at(12345), 0);
  EXPECT_THROW(SceneOrder(1, 0), InvalidArgument);
}

TEST(BatchShare, CoversTheBatchWithRunsOfNearlyEqualLength) {
  for (int processes = 1; processes <= 7; ++processes) {
    std::int64_t next = 3 * 11;
    for (int process = 0; process < processes; ++process) {
      const BatchShare share = batch_share(3, 11, process, processes);
      EXPECT_EQ(share.first, next);
      EXPECT_GE(share.count, 11 / processes);
      EXPECT_LE(share.count, 11 / processes + 1);
      next += share.count;
    }
    EXPECT_EQ(next, 4 * 11);
  }
}

TEST(OrderedPrefetch, GivesValuesInOrderAndStaysWithinItsLimit) {
  for (const int threads : {0, 1, 4}) {
    std::atomic<std::int64_t> taken{10}, farthest{0};
    OrderedPrefetch<std::int64_t> values(
        [&](std::int64_t number) {
          const std::int64_t ahead = number - taken;
          if (ahead > farthest) farthest = ahead;
          return number * number;
        },
        10, 200, threads, 5);
    for (std::int64_t number = 10; number < 200; ++number) {
      EXPECT_EQ(values.next(), number * number);
      taken = number + 1;
    }
    EXPECT_LE(farthest, 6);
  }
}

TEST(OrderedPrefetch, ThrowsWhereTheValueWouldBeAndEndsEarly) {
  OrderedPrefetch<int> values(
      [](std::int64_t number) {
        if (number == 3) throw std::runtime_error("three");
        return static_cast<int>(number);
      },
      0, 1000000, 2, 8);
  for (int i = 0; i < 3; ++i) EXPECT_EQ(values.next(), i);
  EXPECT_THROW(values.next(), std::runtime_error);
  EXPECT_EQ(values.next(), 4);
}

}  // namespace
