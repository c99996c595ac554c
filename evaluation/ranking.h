#pragma once

#include <optional>
#include <span>
#include <vector>

/// \file
/// How well a number, such as the uncertainty of a box, tells good from bad (Liu et al., ECCV 2022,
/// section 5.3).

namespace arbox::evaluation {

/// Area under the ROC curve: the probability that a positive has a larger score than a negative,
/// ties counted half. Empty if there are no positives or no negatives.
///
/// Throws InvalidArgument if the lengths differ or a score is NaN. Cost O(n log n).
std::optional<double> roc_auc(std::span<const double> scores, const std::vector<bool>& positive);

/// The same where each item is a positive with some chance only, independently of the others: the
/// expected number of pairs of a positive and a negative that the scores order rightly, ties
/// counted half, over the expected number of such pairs. With chances of 0 and 1 it is roc_auc().
/// Empty if no such pair can be.
///
/// Throws InvalidArgument if the lengths differ, a score is NaN or a chance is not from 0 to 1.
/// Cost O(n log n).
std::optional<double> expected_roc_auc(std::span<const double> scores,
                                       std::span<const double> chances);

/// Spearman's rank correlation in [-1, 1], equal values sharing their mean rank. Empty for fewer
/// than two pairs or where one side is constant.
///
/// Throws InvalidArgument if the lengths differ or a value is NaN. Cost O(n log n).
std::optional<double> spearman_correlation(std::span<const double> first,
                                           std::span<const double> second);

/// Rank of each value from 1 up, equal values sharing their mean rank.
std::vector<double> mean_ranks(std::span<const double> values);

}  // namespace arbox::evaluation
