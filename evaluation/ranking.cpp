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

void require_chances(const char* where, std::span<const double> chances) {
  for (const double chance : chances) {
    if (chance >= 0.0 && chance <= 1.0) continue;
    throw InvalidArgument(std::string(where) + ": expected chances from 0 to 1, got " +
                          std::to_string(chance));
  }
}

std::vector<std::size_t> rising_order(std::span<const double> values) {
  std::vector<std::size_t> order(values.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(),
            [&](std::size_t i, std::size_t j) { return values[i] < values[j]; });
  return order;
}

}  // namespace

std::vector<double> mean_ranks(std::span<const double> values) {
  require_numbers("mean_ranks", values);
  const std::vector<std::size_t> order = rising_order(values);
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

std::optional<double> expected_roc_auc(std::span<const double> scores,
                                       std::span<const double> chances) {
  require_equal_lengths("expected_roc_auc", scores.size(), chances.size());
  require_numbers("expected_roc_auc", scores);
  require_chances("expected_roc_auc", chances);
  const std::vector<std::size_t> order = rising_order(scores);
  double in_order = 0.0, pairs = 0.0, lower_negatives = 0.0, positives = 0.0;
  for (std::size_t begin = 0; begin < order.size();) {
    std::size_t end = begin;
    double tied_positives = 0.0, tied_negatives = 0.0, with_itself = 0.0;
    for (; end < order.size() && scores[order[end]] == scores[order[begin]]; ++end) {
      const double chance = chances[order[end]];
      tied_positives += chance;
      tied_negatives += 1.0 - chance;
      with_itself += chance * (1.0 - chance);
    }
    const double tied = tied_positives * tied_negatives - with_itself;
    in_order += tied_positives * lower_negatives + 0.5 * tied;
    pairs += tied_positives * lower_negatives + tied + positives * tied_negatives;
    lower_negatives += tied_negatives;
    positives += tied_positives;
    begin = end;
  }
  constexpr double kRounding = 1e-12;
  if (pairs <= kRounding * static_cast<double>(scores.size())) return std::nullopt;
  return std::clamp(in_order / pairs, 0.0, 1.0);
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
