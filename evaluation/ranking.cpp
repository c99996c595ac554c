#include "arbox/evaluation/ranking.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>

#include "arbox/base/error.h"

namespace arbox::evaluation {
namespace {

void require_equal_lengths(const char* where, std::size_t first, std::size_t second) {
  if (first != second) {
    throw InvalidArgument(std::string(where) + ": expected equal lengths, got " +
                          std::to_string(first) + " and " + std::to_string(second));
  }
}

void require_numbers(const char* where, std::span<const double> values) {
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (std::isnan(values[i])) {
      throw InvalidArgument(std::string(where) + ": value " + std::to_string(i) +
                            " is not a number");
    }
  }
}

}  // namespace

std::vector<double> mean_ranks(std::span<const double> values) {
  require_numbers("mean_ranks", values);
  std::vector<std::size_t> order(values.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(),
            [&](std::size_t i, std::size_t j) { return values[i] < values[j]; });
  std::vector<double> ranks(values.size());
  for (std::size_t begin = 0; begin < order.size();) {
    std::size_t end = begin + 1;
    while (end < order.size() && values[order[end]] == values[order[begin]]) ++end;
    const double rank = 0.5 * static_cast<double>(begin + 1 + end);
    for (; begin < end; ++begin) ranks[order[begin]] = rank;
  }
  return ranks;
}

std::optional<double> roc_auc(std::span<const double> scores, const std::vector<bool>& positive) {
  require_equal_lengths("roc_auc", scores.size(), positive.size());
  const std::vector<double> ranks = mean_ranks(scores);
  double rank_sum = 0.0;
  double positives = 0.0;
  for (std::size_t i = 0; i < ranks.size(); ++i) {
    if (!positive[i]) continue;
    rank_sum += ranks[i];
    positives += 1.0;
  }
  const double negatives = static_cast<double>(ranks.size()) - positives;
  if (positives == 0.0 || negatives == 0.0) return std::nullopt;
  return (rank_sum - 0.5 * positives * (positives + 1.0)) / (positives * negatives);
}

std::optional<double> spearman_correlation(std::span<const double> first,
                                           std::span<const double> second) {
  require_equal_lengths("spearman_correlation", first.size(), second.size());
  const std::vector<double> x = mean_ranks(first);
  const std::vector<double> y = mean_ranks(second);
  const double mean = 0.5 * (static_cast<double>(x.size()) + 1.0);
  double xx = 0.0, yy = 0.0, xy = 0.0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    xx += (x[i] - mean) * (x[i] - mean);
    yy += (y[i] - mean) * (y[i] - mean);
    xy += (x[i] - mean) * (y[i] - mean);
  }
  if (xx == 0.0 || yy == 0.0) return std::nullopt;
  return std::clamp(xy / std::sqrt(xx * yy), -1.0, 1.0);
}

}  // namespace arbox::evaluation
