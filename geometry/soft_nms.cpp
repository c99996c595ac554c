#include <cmath>
#include <queue>
#include <vector>

#include "arbox/geometry/internal/candidates.h"

namespace arbox::geometry::internal {
namespace {

struct Entry {
  double score;
  std::int64_t original;
  std::int32_t candidate;

  /// Lower in the queue.
  bool operator<(const Entry& other) const {
    return score < other.score || (score == other.score && original > other.original);
  }
};

/// Takes the box with the best score of the moment and lowers the scores around it.
class SoftSuppression {
 public:
  SoftSuppression(const Candidates& candidates, const NmsOptions& options)
      : candidates_(candidates),
        options_(options),
        reach_(options.soft == "gaussian" ? 0.0 : options.threshold),
        grid_(candidates.make_grid()),
        open_(candidates.size(), 1) {
    for (std::int32_t i = 0; i < candidates.size(); ++i) {
      candidates.insert(grid_, i);
      scores_.push_back(candidates.score(i));
      queue_.push({scores_[i], candidates.original(i), i});
    }
  }

  NmsResult run() {
    NmsResult result;
    while (!queue_.empty() && !full(result)) {
      const Entry best = queue_.top();
      queue_.pop();
      // Scores only fall: an entry that is not the score of today is a leftover.
      if (!open_[best.candidate] || best.score != scores_[best.candidate]) continue;
      open_[best.candidate] = 0;
      result.kept.push_back(best.original);
      result.scores.push_back(best.score);
      lower_around(best.candidate);
    }
    return result;
  }

 private:
  bool full(const NmsResult& result) const {
    return options_.post_limit > 0 &&
           result.kept.size() >= static_cast<std::size_t>(options_.post_limit);
  }

  double decay(double overlap) const {
    if (options_.soft == "gaussian") return std::exp(-overlap * overlap / options_.soft_sigma);
    return overlap > options_.threshold ? 1.0 - overlap : 1.0;
  }

  void lower_around(std::int32_t best) {
    std::vector<std::int32_t> rivals;
    candidates_.visit_rivals(grid_, best, reach_, [&](std::int32_t j) {
      if (open_[j]) rivals.push_back(j);
    });
    std::vector<double> overlaps(rivals.size(), 0.0);
    PairBatch batch(overlap_kernels(simd_level()), Overlap::kIou);
    for (std::size_t r = 0; r < rivals.size(); ++r) {
      batch.add(candidates_.box(best), candidates_.box(rivals[r]), &overlaps[r]);
    }
    batch.flush();
    for (std::size_t r = 0; r < rivals.size(); ++r) lower(rivals[r], decay(overlaps[r]));
  }

  void lower(std::int32_t candidate, double factor) {
    const double lowered = factor * scores_[candidate];
    if (lowered == scores_[candidate]) return;
    scores_[candidate] = lowered;
    if (lowered >= options_.minimum_score) {
      queue_.push({lowered, candidates_.original(candidate), candidate});
    } else {
      open_[candidate] = 0;
    }
  }

  const Candidates& candidates_;
  const NmsOptions& options_;
  double reach_;
  NearGrid grid_;
  std::vector<char> open_;
  std::vector<double> scores_;
  std::priority_queue<Entry> queue_;
};

}  // namespace

NmsResult soft_nms(const Candidates& candidates, const NmsOptions& options) {
  return SoftSuppression(candidates, options).run();
}

}  // namespace arbox::geometry::internal
