#include "arbox/base/parallel.h"

#include <gtest/gtest.h>
#include <omp.h>

#include <atomic>
#include <cmath>
#include <stdexcept>
#include <thread>
#include <vector>

#include "arbox/base/error.h"

namespace {

using arbox::parallel_for;

// Sums within ranges, so that the bytes depend on where the ranges are cut.
std::vector<double> range_sums(std::int64_t count, std::int64_t grain, int threads) {
  std::vector<double> sums(static_cast<std::size_t>(count), 0.0);
  parallel_for(count, grain, threads, [&](std::int64_t begin, std::int64_t end) {
    double sum = 0;
    for (std::int64_t i = begin; i < end; ++i) {
      sum += std::sin(static_cast<double>(i));
      sums[static_cast<std::size_t>(i)] = sum;
    }
  });
  return sums;
}

TEST(ParallelFor, GivesTheSameBytesAtAnyThreadCount) {
  const auto one = range_sums(10'007, 13, 1);
  for (const int threads : {2, 3, 8, 64}) EXPECT_EQ(range_sums(10'007, 13, threads), one);
}

TEST(ParallelFor, CoversEachIndexOnceInRangesOfAtMostTheGrain) {
  for (const std::int64_t grain : {1, 7, 100, 1000}) {
    std::vector<std::atomic<int>> visits(100);
    parallel_for(100, grain, 4, [&](std::int64_t begin, std::int64_t end) {
      EXPECT_LE(end - begin, grain);
      for (std::int64_t i = begin; i < end; ++i) ++visits[static_cast<std::size_t>(i)];
    });
    for (const auto& count : visits) EXPECT_EQ(count, 1);
  }
}

TEST(ParallelFor, NothingToDoCallsNothing) {
  const auto fail = [](std::int64_t, std::int64_t) { FAIL(); };
  parallel_for(0, 1, 4, fail);
  parallel_for(-5, 1, 4, fail);
}

TEST(ParallelFor, TakesAGrainBelowOneAsOne) {
  std::atomic<int> calls{0};
  parallel_for(5, 0, 2, [&](std::int64_t begin, std::int64_t end) { calls += int(end - begin); });
  EXPECT_EQ(calls, 5);
}

TEST(ParallelFor, RethrowsOnTheCallersThreadAndCanBeUsedAgain) {
  for (const int threads : {1, 4}) {
    EXPECT_THROW(parallel_for(100, 1, threads,
                              [](std::int64_t begin, std::int64_t) {
                                if (begin == 37) throw std::out_of_range("row 37");
                              }),
                 std::out_of_range);
  }
  EXPECT_EQ(range_sums(50, 5, 4), range_sums(50, 5, 1));
}

TEST(ParallelFor, NestedRunsInOrderOnTheOuterThread) {
  std::atomic<int> total{0};
  parallel_for(8, 1, 4, [&](std::int64_t, std::int64_t) {
    std::vector<std::int64_t> order;
    parallel_for(20, 3, 4, [&](std::int64_t begin, std::int64_t end) {
      for (std::int64_t i = begin; i < end; ++i) order.push_back(i);
    });
    for (std::size_t i = 0; i < order.size(); ++i) {
      EXPECT_EQ(order[i], static_cast<std::int64_t>(i));
    }
    total += static_cast<int>(order.size());
  });
  EXPECT_EQ(total, 8 * 20);
}

TEST(DefaultThreads, IsWhatWasSetAndRefusesLessThanOne) {
  arbox::set_default_threads(3);
  EXPECT_EQ(arbox::default_threads(), 3);
  EXPECT_THROW(arbox::set_default_threads(0), arbox::InvalidArgument);
  EXPECT_THROW(arbox::set_default_threads(-1), arbox::InvalidArgument);
  EXPECT_EQ(arbox::default_threads(), 3);
}

TEST(DefaultThreads, StayWhatTheyWereWhenAnotherLibraryChangesOpenMp) {
  const int before = arbox::default_threads(), openmp = omp_get_max_threads();
  omp_set_num_threads(openmp + 3);
  EXPECT_EQ(arbox::default_threads(), before);
  omp_set_num_threads(openmp);
}

TEST(ThreadScope, HoldsForItsThreadAndIsUndoneAtItsEnd) {
  const int before = arbox::default_threads(), openmp = omp_get_max_threads();
  {
    const arbox::ThreadScope outer(5);
    EXPECT_EQ(arbox::default_threads(), 5);
    EXPECT_EQ(omp_get_max_threads(), 5);
    {
      const arbox::ThreadScope inner(2), same(0);
      EXPECT_EQ(arbox::default_threads(), 2);
      EXPECT_EQ(omp_get_max_threads(), 2);
    }
    EXPECT_EQ(arbox::default_threads(), 5);
    EXPECT_EQ(omp_get_max_threads(), 5);
    int elsewhere = 0;
    std::thread([&] { elsewhere = arbox::default_threads(); }).join();
    EXPECT_EQ(elsewhere, before);
  }
  EXPECT_EQ(arbox::default_threads(), before);
  EXPECT_EQ(omp_get_max_threads(), openmp);
}

TEST(Errors, AreCaughtAsErrorAndAsRuntimeErrorWithTheirText) {
  const auto text_of = [](const auto& thrown) -> std::string {
    try {
      throw thrown;
    } catch (const arbox::Error& error) {
      const std::runtime_error& base = error;
      return base.what();
    }
  };
  EXPECT_EQ(text_of(arbox::InvalidArgument("a")), "a");
  EXPECT_EQ(text_of(arbox::ConfigError("b")), "b");
  EXPECT_EQ(text_of(arbox::IoError("c")), "c");
  EXPECT_EQ(text_of(arbox::FormatError("d")), "d");
  EXPECT_EQ(text_of(arbox::PluginError("e")), "e");
  EXPECT_EQ(text_of(arbox::NumericalError("f")), "f");
  EXPECT_EQ(text_of(arbox::NotAvailable("g")), "g");
}

}  // namespace
