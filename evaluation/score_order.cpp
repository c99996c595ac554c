#include "arbox/evaluation/internal/score_order.h"

#include <algorithm>
#include <bit>
#include <numeric>
#include <utility>

namespace arbox::evaluation {
namespace {

constexpr std::size_t kInsertionLimit = 16;

class Sorter {
 public:
  Sorter(std::span<const double> scores, std::vector<std::size_t>& order)
      : scores_(scores), order_(order) {}

  /// Sorts [first, first + count).
  void sort(std::size_t first, std::size_t count, int depth) {
    if (count <= kInsertionLimit || depth < 0) {
      // Both give equal scores the order that they have.
      std::stable_sort(order_.begin() + static_cast<std::ptrdiff_t>(first),
                       order_.begin() + static_cast<std::ptrdiff_t>(first + count),
                       [&](std::size_t a, std::size_t b) { return scores_[a] > scores_[b]; });
      return;
    }
    const std::size_t pivot = partition(first, first + count - 1);
    sort(first, pivot - first, depth - 1);
    sort(pivot + 1, first + count - 1 - pivot, depth - 1);
  }

 private:
  bool before(std::size_t i, std::size_t j) const {
    return scores_[order_[i]] > scores_[order_[j]];
  }
  void sort_two(std::size_t i, std::size_t j) {
    if (before(j, i)) std::swap(order_[i], order_[j]);
  }

  /// Hoare's partition around the median of first, middle and last; gives the pivot's place.
  std::size_t partition(std::size_t first, std::size_t last) {
    const std::size_t middle = first + (last - first) / 2;
    sort_two(first, middle);
    sort_two(middle, last);
    sort_two(first, middle);
    const std::size_t pivot = last - 1;
    std::swap(order_[middle], order_[pivot]);
    std::size_t up = first;
    std::size_t down = pivot;
    while (true) {
      do ++up;
      while (before(up, pivot));
      do --down;
      while (before(pivot, down));
      if (up >= down) break;
      std::swap(order_[up], order_[down]);
    }
    std::swap(order_[up], order_[pivot]);
    return up;
  }

  std::span<const double> scores_;
  std::vector<std::size_t>& order_;
};

}  // namespace

std::vector<std::size_t> descending_order(std::span<const double> scores) {
  std::vector<std::size_t> order(scores.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  Sorter(scores, order).sort(0, order.size(), 2 * (std::bit_width(order.size()) - 1));
  return order;
}

}  // namespace arbox::evaluation
