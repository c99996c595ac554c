#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace arbox::evaluation {

/// Indices of the scores from the highest down, equal ones in the order that NumPy's
/// `argsort(-scores)` gives them (median-of-three quicksort, insertion sort up to 16 elements, no
/// vector instructions). The indoor reference tools sort so, and where many scores are equal their
/// figures depend on it. Cost O(n log n).
std::vector<std::size_t> descending_order(std::span<const double> scores);

}  // namespace arbox::evaluation
