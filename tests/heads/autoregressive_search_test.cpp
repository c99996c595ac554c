#include "arbox/heads/internal/autoregressive_search.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <vector>

#include "arbox/heads/internal/row_smoother.h"
#include "heads/random_network.h"

namespace arbox::heads::internal {
namespace {

using testing::enumerate;
using testing::EnumeratedVector;
using testing::normal_floats;
using testing::random_network;
using testing::RandomNetwork;

constexpr std::int32_t kFeatures = 5;

FeatureRows rows_of(const std::vector<float>& features) {
  return {features.data(), std::ssize(features) / kFeatures, kFeatures};
}

std::vector<std::int64_t> ids_of(std::int64_t objects, std::int64_t first = 0) {
  std::vector<std::int64_t> ids(objects);
  std::iota(ids.begin(), ids.end(), first);
  return ids;
}

std::vector<std::int32_t> bins_of(const Vectors& vectors, std::int64_t object, std::int32_t k,
                                  std::int32_t known = 0) {
  const auto row = vectors.bins.begin() + (object * vectors.count + k) * vectors.components;
  return {row + known, row + vectors.components};
}

std::vector<EnumeratedVector> best_first(std::vector<EnumeratedVector> all) {
  std::stable_sort(all.begin(), all.end(), [](const auto& a, const auto& b) {
    return a.log_probability > b.log_probability;
  });
  return all;
}

void expect_beams(const Vectors& beams, std::int64_t object,
                  const std::vector<EnumeratedVector>& expected, std::int32_t count,
                  std::int32_t known = 0) {
  for (std::int32_t k = 0; k < count; ++k) {
    EXPECT_EQ(bins_of(beams, object, k, known), expected[k].bins) << "beam " << k;
    EXPECT_NEAR(beams.log_probability[object * beams.count + k], expected[k].log_probability, 2e-5);
  }
}

/// The vectors of `all` with the product of the smoothed conditionals in place of the plain one.
std::vector<EnumeratedVector> smoothed(const std::vector<EnumeratedVector>& all,
                                       const std::vector<std::int32_t>& bins, double smoothing) {
  std::vector<EnumeratedVector> result = all;
  for (EnumeratedVector& one : result) one.log_probability = 0.0;
  RowSmoother smoother(smoothing);
  for (std::size_t component = 0; component < bins.size(); ++component) {
    std::map<std::vector<std::int32_t>, std::vector<double>> marginals;  // by prefix
    const auto prefix = [&](const EnumeratedVector& vector) {
      return std::vector(vector.bins.begin(), vector.bins.begin() + component);
    };
    for (const EnumeratedVector& vector : all) {
      auto& marginal = marginals[prefix(vector)];
      marginal.resize(bins[component]);
      marginal[vector.bins[component]] += std::exp(vector.log_probability);
    }
    std::map<std::vector<std::int32_t>, std::vector<float>> rows;
    for (const auto& [key, marginal] : marginals) {
      const double sum = std::accumulate(marginal.begin(), marginal.end(), 0.0);
      for (const double one : marginal)
        rows[key].push_back(static_cast<float>(std::log(one / sum)));
      smoother.smooth(rows[key], component == 2);
    }
    for (EnumeratedVector& vector : result) {
      vector.log_probability += rows[prefix(vector)][vector.bins[component]];
    }
  }
  return result;
}

TEST(BeamSearch, FindsTheBestOfTheSmoothedConditionals) {
  const std::vector<std::int32_t> bins = {6, 8, 7};
  RandomNetwork network = random_network(kFeatures, {9, 20}, bins, 1, 4.0);
  network.components[2].circular = true;
  const auto features = normal_floats(3 * kFeatures, 2, 1.0);
  const PackedNetwork packed = network.packed();
  const Vectors beams =
      beam_search(packed, rows_of(features), {.width = 336, .smoothing = 1.2}, {}, {});
  for (std::int64_t object = 0; object < 3; ++object) {
    const auto all = enumerate(network, features.data() + object * kFeatures);
    const auto expected = best_first(smoothed(all, bins, 1.2));
    expect_beams(beams, object, expected, 40);
    EXPECT_NE(bins_of(beams, object, 0), bins_of(beams, object, 335));
  }
}

TEST(BeamSearch, ReturnsEveryVectorInOrderWhenItIsWideEnough) {
  const RandomNetwork network = random_network(kFeatures, {9, 20}, {4, 5, 3}, 1);
  const auto features = normal_floats(3 * kFeatures, 2, 1.0);
  const Vectors beams = beam_search(network.packed(), rows_of(features), {.width = 70}, {}, {});
  ASSERT_EQ(beams.count, 70);
  for (std::int64_t object = 0; object < 3; ++object) {
    expect_beams(beams, object,
                 best_first(enumerate(network, features.data() + object * kFeatures)), 60);
    EXPECT_EQ(beams.log_probability[object * 70 + 60], -std::numeric_limits<float>::infinity());
  }
}

TEST(BeamSearch, EqualsExhaustiveSearchWhenEveryPrefixFits) {
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    const RandomNetwork network = random_network(kFeatures, {16}, {4, 5, 3}, 10 * seed);
    const auto features = normal_floats(kFeatures, seed, 1.0);
    expect_beams(beam_search(network.packed(), rows_of(features), {.width = 20}, {}, {}), 0,
                 best_first(enumerate(network, features.data())), 20);
  }
}

TEST(BeamSearch, OfWidthOneIsGreedy) {
  const RandomNetwork network = random_network(kFeatures, {16}, {6, 7, 8, 5}, 3);
  const auto features = normal_floats(4 * kFeatures, 4, 1.0);
  const Vectors beams = beam_search(network.packed(), rows_of(features), {.width = 1}, {}, {});
  for (std::int64_t object = 0; object < 4; ++object) {
    std::vector<double> input(features.begin() + object * kFeatures,
                              features.begin() + (object + 1) * kFeatures);
    double sum = 0.0;
    for (std::int32_t i = 0; i < 4; ++i) {
      const auto log_probability = testing::naive_log_probabilities(network.components[i], input);
      const auto best = std::max_element(log_probability.begin(), log_probability.end());
      EXPECT_EQ(bins_of(beams, object, 0)[i], best - log_probability.begin());
      sum += *best;
      input.push_back(0.5 * static_cast<double>(best - log_probability.begin()));
    }
    EXPECT_NEAR(beams.log_probability[object], sum, 2e-5);
  }
}

TEST(BeamSearch, StartsFromOneLiveBeamAfterConditioning) {
  const RandomNetwork network = random_network(kFeatures, {16}, {4, 5, 6, 7}, 5);
  const auto features = normal_floats(2 * kFeatures, 6, 1.0);
  const std::vector<float> known{0.3f, 1.7f, 1.1f, 0.2f};
  const Vectors beams =
      beam_search(network.packed(), rows_of(features), {.width = 42}, {known, 2}, {});
  for (std::int64_t object = 0; object < 2; ++object) {
    const auto expected = best_first(enumerate(network, features.data() + object * kFeatures,
                                               {known[2 * object], known[2 * object + 1]}));
    expect_beams(beams, object, expected, 42, 2);
    EXPECT_EQ(beams.values[object * 42 * 4], known[2 * object]);
    EXPECT_EQ(beams.bins[object * 42 * 4 + 1], -1);
  }
}

TEST(BeamSearch, TiesGoToTheEarlierBeamThenTheLowerBin) {
  RandomNetwork network = random_network(kFeatures, {8}, {4, 4}, 1);
  for (auto& storage : network.storage) std::fill(storage.begin(), storage.end(), 0.0f);
  const Vectors beams =
      beam_search(network.packed(), rows_of(std::vector<float>(kFeatures)), {.width = 6}, {}, {});
  const std::vector<std::vector<std::int32_t>> expected{{0, 0}, {0, 1}, {0, 2},
                                                        {0, 3}, {1, 0}, {1, 1}};
  for (std::int32_t k = 0; k < 6; ++k) EXPECT_EQ(bins_of(beams, 0, k), expected[k]);
}

/// Chi-square statistic of draws against the enumerated probabilities; vectors that expect fewer
/// than 5 draws are pooled.
struct ChiSquare {
  double statistic = 0.0;
  int degrees = -1;
};

ChiSquare chi_square(const Vectors& draws, const std::vector<EnumeratedVector>& expected,
                     const std::vector<std::int32_t>& radix) {
  std::vector<double> counts(expected.size());
  for (std::int32_t k = 0; k < draws.count; ++k) {
    std::size_t index = 0;
    const auto bins = bins_of(draws, 0, k);
    for (std::size_t i = 0; i < radix.size(); ++i) index = index * radix[i] + bins[i];
    ++counts.at(index);
  }
  ChiSquare result;
  double pooled_count = 0.0, pooled = 0.0;
  const auto add = [&](double count, double expectation) {
    result.statistic += (count - expectation) * (count - expectation) / expectation;
    ++result.degrees;
  };
  for (std::size_t v = 0; v < counts.size(); ++v) {
    const double expectation = draws.count * std::exp(expected[v].log_probability);
    if (expectation < 5) {
      pooled_count += counts[v];
      pooled += expectation;
    } else {
      add(counts[v], expectation);
    }
  }
  if (pooled > 0) add(pooled_count, std::max(pooled, 1e-9));
  return result;
}

TEST(Sampling, FrequenciesAreTheEnumeratedProbabilities) {
  const std::vector<std::int32_t> bins{5, 70, 3};
  const RandomNetwork network = random_network(kFeatures, {16, 16}, bins, 7);
  const auto features = normal_floats(kFeatures, 8, 1.0);
  for (const double temperature : {1.0, 0.5, 2.0}) {
    const Vectors draws =
        sample(network.packed(), rows_of(features), ids_of(1), 11, 200000, temperature, {}, {});
    const auto [statistic, degrees] =
        chi_square(draws, enumerate(network, features.data(), {}, temperature), bins);
    ASSERT_GT(degrees, 20);
    // Mean `degrees`, variance twice that: five deviations.
    EXPECT_LT(statistic, degrees + 5 * std::sqrt(2.0 * degrees)) << "temperature " << temperature;
  }
}

TEST(Sampling, LogProbabilitiesAreTheNetworksAtAnyTemperature) {
  const std::vector<std::int32_t> bins{5, 6, 7};
  const RandomNetwork network = random_network(kFeatures, {16}, bins, 9);
  const auto features = normal_floats(2 * kFeatures, 8, 1.0);
  for (const double temperature : {1.0, 0.3}) {
    const Vectors draws =
        sample(network.packed(), rows_of(features), ids_of(2), 1, 50, temperature, {}, {});
    const auto scored =
        log_probability(network.packed(), rows_of(features), draws.values, 50, {0, 3}, {});
    for (std::int64_t object = 0; object < 2; ++object) {
      const auto all = enumerate(network, features.data() + object * kFeatures);
      for (std::int32_t k = 0; k < 50; ++k) {
        const auto b = bins_of(draws, object, k);
        const double expected = all[(b[0] * 6 + b[1]) * 7 + b[2]].log_probability;
        EXPECT_NEAR(draws.log_probability[object * 50 + k], expected, 2e-5);
        EXPECT_NEAR(scored[object * 50 + k], expected, 2e-5);
        EXPECT_EQ(draws.values[(object * 50 + k) * 3 + 2], 0.5f * static_cast<float>(b[2]));
      }
    }
  }
}

TEST(Sampling, LowTemperatureIsGreedy) {
  const RandomNetwork network = random_network(kFeatures, {16}, {50, 60}, 9);
  const auto features = normal_floats(kFeatures, 8, 1.0);
  const Vectors draws = sample(network.packed(), rows_of(features), ids_of(1), 1, 5, 1e-40, {}, {});
  const Vectors greedy = beam_search(network.packed(), rows_of(features), {.width = 1}, {}, {});
  for (std::int32_t k = 0; k < 5; ++k) EXPECT_EQ(bins_of(draws, 0, k), bins_of(greedy, 0, 0));
}

TEST(Sampling, DrawsDoNotDependOnTheBatch) {
  const std::int64_t objects = 157;
  const std::int32_t count = 64;  // 10048 draws
  const RandomNetwork network = random_network(kFeatures, {64, 128}, {512, 512, 511}, 21);
  const PackedNetwork packed = network.packed();
  const auto features = normal_floats(objects * kFeatures, 22, 1.0);
  const auto ids = ids_of(objects, 1000);
  const Vectors together = sample(packed, rows_of(features), ids, 5, count, 1.0, {}, {});
  std::int64_t equal = 0;
  for (std::int64_t object = 0; object < objects; ++object) {
    const Vectors alone = sample(packed, {features.data() + object * kFeatures, 1, kFeatures},
                                 {&ids[object], 1}, 5, count, 1.0, {}, {});
    for (std::int32_t k = 0; k < count; ++k) {
      equal += bins_of(alone, 0, k) == bins_of(together, object, k);
    }
  }
  EXPECT_GE(static_cast<double>(equal), 0.999 * static_cast<double>(objects * count));
}

TEST(Sampling, BytesDoNotDependOnThreadsOrChunks) {
  const RandomNetwork network = random_network(kFeatures, {64, 128}, {512, 512, 511}, 21);
  const PackedNetwork packed = network.packed();
  const auto features = normal_floats(40 * kFeatures, 22, 1.0);
  const auto ids = ids_of(40);
  const auto run = [&](const SearchOptions& options) {
    return sample(packed, rows_of(features), ids, 5, 10, 1.0, {}, options);
  };
  const auto search = [&](const SearchOptions& options) {
    return beam_search(packed, rows_of(features), {.width = 10}, {}, options);
  };
  const Vectors draws = run({.threads = 1}), beams = search({.threads = 1});
  for (const SearchOptions& options :
       {SearchOptions{.threads = 2}, SearchOptions{.threads = 3},
        SearchOptions{.threads = 2, .rows_at_once = 1}, SearchOptions{.rows_at_once = 35}}) {
    EXPECT_EQ(run(options).values, draws.values);
    EXPECT_EQ(run(options).log_probability, draws.log_probability);
    EXPECT_EQ(search(options).values, beams.values);
    EXPECT_EQ(search(options).log_probability, beams.log_probability);
  }
}

TEST(Sampling, ObjectsWithDifferentIdsDrawDifferently) {
  const RandomNetwork network = random_network(kFeatures, {16}, {512, 512}, 3);
  std::vector<float> features(2 * kFeatures, 0.5f);
  const std::vector<std::int64_t> ids{4, 9};
  const Vectors draws = sample(network.packed(), rows_of(features), ids, 1, 8, 1.0, {}, {});
  int equal = 0;
  for (std::int32_t k = 0; k < 8; ++k) equal += bins_of(draws, 0, k) == bins_of(draws, 1, k);
  EXPECT_LE(equal, 1);
}

TEST(Sampling, KnownComponentsStay) {
  const std::vector<std::int32_t> bins{5, 6, 7};
  const RandomNetwork network = random_network(kFeatures, {16}, bins, 9);
  const auto features = normal_floats(kFeatures, 8, 1.0);
  const std::vector<float> known{0.77f};
  const Vectors draws =
      sample(network.packed(), rows_of(features), ids_of(1), 3, 20000, 1.0, {known, 1}, {});
  const auto all = enumerate(network, features.data(), {known[0]});
  std::vector<double> counts(all.size());
  for (std::int32_t k = 0; k < draws.count; ++k) {
    ASSERT_EQ(draws.values[k * 3], 0.77f);
    const auto b = bins_of(draws, 0, k, 1);
    ++counts[b[0] * 7 + b[1]];
  }
  for (std::size_t v = 0; v < all.size(); ++v) {
    const double p = std::exp(all[v].log_probability);
    EXPECT_NEAR(counts[v], 20000 * p, 5 * std::sqrt(20000 * p) + 3);
  }
}

TEST(Search, NetworksWithoutHiddenLayersAndEmptyBatchesAreFine) {
  const RandomNetwork network = random_network(kFeatures, {}, {3, 4}, 9);
  const auto features = normal_floats(kFeatures, 8, 1.0);
  expect_beams(beam_search(network.packed(), rows_of(features), {.width = 12}, {}, {}), 0,
               best_first(enumerate(network, features.data())), 12);
  const FeatureRows nothing{nullptr, 0, kFeatures};
  EXPECT_TRUE(sample(network.packed(), nothing, {}, 1, 5, 1.0, {}, {}).values.empty());
  EXPECT_TRUE(beam_search(network.packed(), nothing, {.width = 5}, {}, {}).values.empty());
  EXPECT_TRUE(log_probability(network.packed(), nothing, {}, 5, {0, 2}, {}).empty());
  EXPECT_TRUE(
      sample(network.packed(), rows_of(features), ids_of(1), 1, 0, 1.0, {}, {}).values.empty());
}

TEST(Search, OutputsThatAreNotFiniteGiveNaN) {
  RandomNetwork network = random_network(kFeatures, {8}, {4, 4}, 1);
  std::fill(network.storage.front().begin(), network.storage.front().end(), std::nanf(""));
  const auto features = normal_floats(kFeatures, 8, 1.0);
  const Vectors draws = sample(network.packed(), rows_of(features), ids_of(1), 1, 3, 1.0, {}, {});
  const Vectors beams = beam_search(network.packed(), rows_of(features), {.width = 3}, {}, {});
  for (std::int32_t k = 0; k < 3; ++k) {
    EXPECT_TRUE(std::isnan(draws.values[2 * k]));
    EXPECT_TRUE(std::isnan(draws.log_probability[k]));
    EXPECT_TRUE(std::isnan(beams.values[2 * k]));
  }
}

}  // namespace
}  // namespace arbox::heads::internal
