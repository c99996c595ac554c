#include "arbox/geometry/nms.h"

#include <algorithm>
#include <utility>

#include "arbox/base/parallel.h"
#include "arbox/geometry/internal/candidates.h"

namespace arbox::geometry {
namespace {

using namespace internal;

// Candidates that are compared with what is kept at once; few at first, while much is kept.
constexpr std::int32_t kFirstBlock = 32;
constexpr std::int32_t kLargestBlock = 1024;
// Waking threads pays from here on.
constexpr std::int32_t kThreadedCount = 8192;
constexpr std::int32_t kThreadedBlock = 4096;
constexpr std::int32_t kGrain = 512;

/// Greedy suppression, block by block. What is kept before a block is compared with all of the
/// block in parallel, what is left of the block one after another.
class Suppression {
 public:
  Suppression(const Candidates& candidates, const NmsOptions& options)
      : candidates_(candidates),
        options_(options),
        grid_(candidates.make_grid()),
        gone_(candidates.size(), 0) {}

  std::vector<std::int32_t> run() {
    const bool threaded = candidates_.size() >= kThreadedCount;
    const std::int32_t largest_block = threaded ? kThreadedBlock : kLargestBlock;
    std::int32_t block = kFirstBlock;
    for (std::int32_t begin = 0; begin < candidates_.size() && !full();) {
      const std::int32_t end = std::min(candidates_.size(), begin + block);
      compare_with_kept(begin, end, block >= kThreadedBlock ? options_.threads : 1);
      settle(begin, end);
      begin = end;
      block = std::min(2 * block, largest_block);
    }
    return std::move(kept_);
  }

 private:
  struct Pair {
    std::int32_t candidate, rival;
    double overlap;
  };

  bool full() const {
    return options_.post_limit > 0 && kept_.size() >= static_cast<std::size_t>(options_.post_limit);
  }

  void remove_overlapping(std::vector<Pair>& pairs) {
    PairBatch batch(overlap_kernels(simd_level()), Overlap::kIou);
    for (Pair& pair : pairs) {
      if (gone_[pair.candidate]) continue;
      pair.overlap = 0.0;
      batch.add(candidates_.box(pair.rival), candidates_.box(pair.candidate), &pair.overlap);
    }
    batch.flush();
    for (const Pair& pair : pairs) {
      if (pair.overlap > options_.threshold) gone_[pair.candidate] = 1;
    }
  }

  void compare_with_kept(std::int32_t begin, std::int32_t end, int threads) {
    const auto compare = [&](std::int64_t first, std::int64_t last) {
      compare_range(begin + static_cast<std::int32_t>(first),
                    begin + static_cast<std::int32_t>(last));
    };
    parallel_for(end - begin, kGrain, threads, compare);
  }

  /// The nearest kept box first, since it is the likeliest to remove; then the others.
  void compare_range(std::int32_t begin, std::int32_t end) {
    std::vector<Pair> nearest, others;
    for (std::int32_t i = begin; i < end; ++i) {
      std::int32_t best = -1;
      double least = 0.0;
      candidates_.visit_rivals(grid_, i, options_.threshold, [&](std::int32_t j) {
        const double distance = candidates_.squared_distance(i, j);
        std::int32_t other = j;
        if (best < 0 || distance < least) {
          std::swap(best, other);
          least = distance;
        }
        if (other >= 0) others.push_back({i, other, 0.0});
      });
      if (best >= 0) nearest.push_back({i, best, 0.0});
    }
    remove_overlapping(nearest);
    remove_overlapping(others);
  }

  void settle(std::int32_t begin, std::int32_t end) {
    std::vector<Pair> pairs;
    for (std::int32_t i = begin; i < end && !full(); ++i) {
      if (gone_[i]) continue;
      pairs.clear();
      candidates_.visit_rivals(grid_, i, options_.threshold, [&](std::int32_t j) {
        if (j >= begin) pairs.push_back({i, j, 0.0});
      });
      remove_overlapping(pairs);
      if (gone_[i]) continue;
      kept_.push_back(i);
      candidates_.insert(grid_, i);
    }
  }

  const Candidates& candidates_;
  const NmsOptions& options_;
  NearGrid grid_;
  std::vector<char> gone_;
  std::vector<std::int32_t> kept_;
};

}  // namespace

NmsResult nms(std::span<const Box> boxes, std::span<const double> scores, const NmsOptions& options,
              std::span<const int> classes) {
  const Candidates candidates(boxes, scores, classes, options);
  if (options.soft != "none") return soft_nms(candidates, options);
  NmsResult result;
  for (const std::int32_t i : Suppression(candidates, options).run()) {
    result.kept.push_back(candidates.original(i));
    result.scores.push_back(candidates.score(i));
  }
  return result;
}

}  // namespace arbox::geometry
