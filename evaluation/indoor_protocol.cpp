#include "arbox/evaluation/indoor_protocol.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "arbox/base/error.h"
#include "arbox/base/parallel.h"
#include "arbox/evaluation/internal/score_order.h"

namespace arbox::evaluation {
namespace {

constexpr int kSweepSteps = 19;

double sweep_threshold(int step) { return (step + 1) / 20.0; }

/// The true box that a prediction claims, whatever the threshold.
struct Claim {
  double score;
  double overlap;
  std::size_t truth;
};

void require_valid(const LabeledBox& box, const IndoorScene& scene, const char* list,
                   std::size_t row) {
  const std::string where = "evaluate_indoor: scene '" + scene.name + "', " + list + " row " +
                            std::to_string(row) + " (" + box.label + ")";
  geometry::require_valid(box.box, where);
  if (!std::isfinite(box.score)) throw InvalidArgument(where + ": expected a finite score");
}

void require_valid(std::span<const IndoorScene> scenes, const IndoorOptions& options) {
  if (options.overlap == geometry::Overlap::kIntersection) {
    throw InvalidArgument("evaluate_indoor: overlap must be IoU or IoG, got the intersection");
  }
  for (const double threshold : options.thresholds) {
    if (!(threshold >= 0.0 && threshold < 1.0)) {
      throw InvalidArgument("evaluate_indoor: expected thresholds in [0, 1), got " +
                            std::to_string(threshold));
    }
  }
  std::set<std::string> names;
  for (const std::string& name : options.classes) {
    if (!names.insert(name).second) {
      throw InvalidArgument("evaluate_indoor: class " + name + " is named twice");
    }
  }
  for (const IndoorScene& scene : scenes) {
    for (std::size_t i = 0; i < scene.truth.size(); ++i) {
      require_valid(scene.truth[i], scene, "truth", i);
    }
    for (std::size_t i = 0; i < scene.predictions.size(); ++i) {
      require_valid(scene.predictions[i], scene, "prediction", i);
    }
  }
}

std::vector<std::string> class_names(std::span<const IndoorScene> scenes,
                                     const IndoorOptions& options) {
  if (!options.classes.empty()) return options.classes;
  std::set<std::string> names;
  for (const IndoorScene& scene : scenes) {
    for (const LabeledBox& box : scene.truth) names.insert(box.label);
  }
  return {names.begin(), names.end()};
}

std::vector<double> all_thresholds(const IndoorOptions& options) {
  std::set<double> thresholds(options.thresholds.begin(), options.thresholds.end());
  for (int step = 0; step < kSweepSteps; ++step) thresholds.insert(sweep_threshold(step));
  return {thresholds.begin(), thresholds.end()};
}

struct ClassInScene {
  std::vector<geometry::Box> truth;
  std::vector<geometry::Box> predictions;
  std::vector<double> scores;
};

ClassInScene of_class(const IndoorScene& scene, const std::string& name) {
  ClassInScene result;
  for (const LabeledBox& box : scene.truth) {
    if (box.label == name) result.truth.push_back(box.box);
  }
  for (const LabeledBox& box : scene.predictions) {
    if (box.label != name) continue;
    result.predictions.push_back(box.box);
    result.scores.push_back(box.score);
  }
  return result;
}

struct SceneClaims {
  std::size_t truth = 0;
  std::vector<Claim> claims;
};

SceneClaims claims_in(const IndoorScene& scene, const std::string& name,
                      geometry::Overlap measure) {
  const ClassInScene boxes = of_class(scene, name);
  SceneClaims result{.truth = boxes.truth.size(), .claims = {}};
  const auto overlaps =
      geometry::overlap_matrix(boxes.predictions, boxes.truth, {.measure = measure, .threads = 1});
  for (std::size_t i = 0; i < boxes.predictions.size(); ++i) {
    Claim claim{.score = boxes.scores[i], .overlap = -1.0, .truth = 0};
    for (std::size_t j = 0; j < boxes.truth.size(); ++j) {
      const double overlap = overlaps(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j));
      if (overlap > claim.overlap) {
        claim.overlap = overlap;
        claim.truth = j;
      }
    }
    result.claims.push_back(claim);
  }
  return result;
}

/// All claims of a class, best score first, with the true boxes of all scenes numbered through.
SceneClaims gather(const std::vector<SceneClaims>& scenes) {
  SceneClaims all;
  std::vector<double> scores;
  for (const SceneClaims& scene : scenes) {
    for (Claim claim : scene.claims) {
      claim.truth += all.truth;
      all.claims.push_back(claim);
      scores.push_back(claim.score);
    }
    all.truth += scene.truth;
  }
  std::vector<Claim> sorted;
  for (const std::size_t i : descending_order(scores)) sorted.push_back(all.claims[i]);
  all.claims = std::move(sorted);
  return all;
}

PrecisionRecall curve_at(const SceneClaims& all, double threshold) {
  PrecisionRecall curve;
  std::vector<char> taken(all.truth, 0);
  std::size_t right = 0;
  for (std::size_t i = 0; i < all.claims.size(); ++i) {
    const Claim& claim = all.claims[i];
    if (!(claim.overlap > threshold) || taken[claim.truth]) continue;
    taken[claim.truth] = 1;
    ++right;
    curve.recall.push_back(static_cast<double>(right) / static_cast<double>(all.truth));
    curve.precision.push_back(static_cast<double>(right) / static_cast<double>(i + 1));
  }
  for (std::size_t i = curve.precision.size(); i-- > 1;) {
    curve.precision[i - 1] = std::max(curve.precision[i - 1], curve.precision[i]);
  }
  return curve;
}

IndoorScore score_of(const PrecisionRecall& curve) {
  IndoorScore score;
  double reached = 0.0;
  for (std::size_t i = 0; i < curve.recall.size(); ++i) {
    score.ap += 100.0 * (curve.recall[i] - reached) * curve.precision[i];
    reached = curve.recall[i];
  }
  score.recall = 100.0 * reached;
  return score;
}

IndoorScore mean_of(const std::vector<IndoorScore>& scores) {
  IndoorScore sum;
  for (const IndoorScore& score : scores) {
    sum.ap += score.ap;
    sum.recall += score.recall;
  }
  const double count = std::max<double>(1.0, static_cast<double>(scores.size()));
  return {.ap = sum.ap / count, .recall = sum.recall / count};
}

IndoorScore sweep_mean(const std::vector<IndoorScore>& scores, const IndoorReport& report) {
  std::vector<IndoorScore> of_sweep;
  of_sweep.reserve(kSweepSteps);
  for (int step = 0; step < kSweepSteps; ++step) {
    of_sweep.push_back(scores[threshold_index(report, sweep_threshold(step))]);
  }
  return mean_of(of_sweep);
}

void add_class_means(IndoorReport& report) {
  for (std::size_t t = 0; t < report.thresholds.size(); ++t) {
    std::vector<IndoorScore> of_classes;
    for (const IndoorClassResult& result : report.classes) {
      if (!result.scores.empty()) of_classes.push_back(result.scores[t]);
    }
    report.class_means.push_back(mean_of(of_classes));
  }
  report.mean = sweep_mean(report.class_means, report);
}

}  // namespace

std::size_t threshold_index(const IndoorReport& report, double threshold) {
  const auto it = std::find(report.thresholds.begin(), report.thresholds.end(), threshold);
  if (it == report.thresholds.end()) {
    throw InvalidArgument("threshold_index: the report has no threshold " +
                          std::to_string(threshold));
  }
  return static_cast<std::size_t>(it - report.thresholds.begin());
}

IndoorReport evaluate_indoor(std::span<const IndoorScene> scenes, const IndoorOptions& options) {
  require_valid(scenes, options);
  IndoorReport report{.overlap = options.overlap,
                      .scenes = static_cast<std::int64_t>(scenes.size()),
                      .thresholds = all_thresholds(options),
                      .classes = {},
                      .class_means = {},
                      .mean = {}};
  for (const std::string& name : class_names(scenes, options)) {
    std::vector<SceneClaims> per_scene(scenes.size());
    parallel_for(static_cast<std::int64_t>(scenes.size()), 1, options.threads,
                 [&](std::int64_t begin, std::int64_t) {
                   const auto i = static_cast<std::size_t>(begin);
                   per_scene[i] = claims_in(scenes[i], name, options.overlap);
                 });
    const SceneClaims all = gather(per_scene);
    IndoorClassResult result;
    result.name = name;
    result.truth = static_cast<std::int64_t>(all.truth);
    result.predictions = static_cast<std::int64_t>(all.claims.size());
    if (all.truth > 0) {
      for (const double threshold : report.thresholds) {
        result.curves.push_back(curve_at(all, threshold));
        result.scores.push_back(score_of(result.curves.back()));
      }
      result.mean = sweep_mean(result.scores, report);
    }
    report.classes.push_back(std::move(result));
  }
  add_class_means(report);
  return report;
}

}  // namespace arbox::evaluation
