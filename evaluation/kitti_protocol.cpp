#include "arbox/evaluation/kitti_protocol.h"

#include <strings.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>

#include "arbox/base/error.h"
#include "arbox/base/parallel.h"
#include "arbox/evaluation/internal/kitti_matching.h"

namespace arbox::evaluation {
namespace {

constexpr std::int64_t kFramesAtOnce = 64;

std::string place(std::size_t frame, const char* list, std::size_t row) {
  return "evaluate_kitti: frame " + std::to_string(frame) + ", " + list + " row " +
         std::to_string(row);
}

void require_finite(const std::vector<io::KittiObject>& objects, std::size_t frame,
                    const char* list) {
  for (std::size_t row = 0; row < objects.size(); ++row) {
    const io::KittiObject& o = objects[row];
    for (const double value : {o.truncation, o.alpha, o.left, o.top, o.right, o.bottom, o.height,
                               o.width, o.length, o.x, o.y, o.z, o.rotation_y, o.score}) {
      if (!std::isfinite(value)) {
        throw InvalidArgument(place(frame, list, row) + ": expected finite numbers, got " +
                              std::to_string(value));
      }
    }
  }
}

void require_valid(const KittiOptions& options) {
  for (const geometry::Overlap overlap : {options.overlap, options.birds_eye_overlap}) {
    if (overlap == geometry::Overlap::kIntersection) {
      throw InvalidArgument("evaluate_kitti: overlap must be IoU or IoG, got the intersection");
    }
  }
  for (auto it = options.classes.begin(); it != options.classes.end(); ++it) {
    for (const double threshold :
         {it->min_overlap.image, it->min_overlap.birds_eye, it->min_overlap.box3d}) {
      if (!(threshold >= 0.0 && threshold < 1.0)) {
        throw InvalidArgument("evaluate_kitti: class " + it->name +
                              ": expected a minimum overlap in [0, 1), got " +
                              std::to_string(threshold));
      }
    }
    if (std::any_of(options.classes.begin(), it, [&](const KittiClass& other) {
          return strcasecmp(other.name.c_str(), it->name.c_str()) == 0;
        })) {
      throw InvalidArgument("evaluate_kitti: class " + it->name + " is named twice");
    }
  }
}

// The scores at which recall comes nearest to 0, 1/40, ..., 1.
std::vector<double> recall_thresholds(std::vector<double> scores, std::int64_t labels) {
  std::sort(scores.begin(), scores.end(), std::greater<>());
  std::vector<double> thresholds;
  double wanted = 0.0;
  for (std::size_t i = 0; i < scores.size(); ++i) {
    const bool last = i + 1 == scores.size();
    const double here = static_cast<double>(i + 1) / static_cast<double>(labels);
    const double next = static_cast<double>(i + 2) / static_cast<double>(labels);
    if (!last && next - wanted < wanted - here) continue;
    thresholds.push_back(scores[i]);
    wanted += 1.0 / (kKittiRecallPoints - 1.0);
  }
  thresholds.resize(std::min(thresholds.size(), kKittiRecallPoints));
  return thresholds;
}

void make_monotone(KittiCurve& curve) {
  for (std::size_t i = kKittiRecallPoints - 1; i > 0; --i) {
    curve.values[i - 1] = std::max(curve.values[i - 1], curve.values[i]);
  }
}

using ThresholdCounts = std::array<KittiMatching::Counts, kKittiRecallPoints>;

struct TaskResult {
  std::int64_t labels = 0;
  KittiCurve precision;
  KittiCurve similarity;
};

TaskResult curves_of(const ThresholdCounts& counts, std::size_t thresholds) {
  TaskResult result;
  for (std::size_t i = 0; i < thresholds; ++i) {
    const auto found = static_cast<double>(counts[i].true_positives + counts[i].false_positives);
    if (found == 0.0) continue;
    result.precision.values[i] = static_cast<double>(counts[i].true_positives) / found;
    result.similarity.values[i] = counts[i].similarity / found;
  }
  make_monotone(result.precision);
  make_monotone(result.similarity);
  return result;
}

TaskResult run(const std::vector<PreparedKittiFrame>& frames, const KittiTask& task) {
  std::vector<double> scores;
  std::int64_t labels = 0;
  std::vector<KittiMatching> matchings;
  matchings.reserve(frames.size());
  for (const PreparedKittiFrame& frame : frames) {
    KittiMatching matching(frame, task);
    labels += matching.valid_labels();
    matching.collect_scores(scores);
    if (matching.has_predictions()) matchings.push_back(std::move(matching));
  }
  const std::vector<double> thresholds = recall_thresholds(std::move(scores), labels);
  ThresholdCounts counts{};
  for (const KittiMatching& matching : matchings) {
    for (std::size_t i = 0; i < thresholds.size(); ++i) {
      const KittiMatching::Counts of_frame = matching.count(thresholds[i]);
      counts[i].true_positives += of_frame.true_positives;
      counts[i].false_positives += of_frame.false_positives;
      counts[i].similarity += of_frame.similarity;
    }
  }
  TaskResult result = curves_of(counts, thresholds.size());
  result.labels = labels;
  return result;
}

struct Presence {
  std::int64_t predictions = 0;
  std::array<bool, kKittiMetrics> metrics{};
};

Presence presence_of(std::span<const KittiFrame> frames, const KittiClass& settings) {
  Presence presence;
  for (const KittiFrame& frame : frames) {
    for (const io::KittiObject& prediction : frame.predictions) {
      if (strcasecmp(prediction.type.c_str(), settings.name.c_str()) != 0) continue;
      ++presence.predictions;
      presence.metrics[kImage] |= prediction.left >= 0.0;
      presence.metrics[kBirdsEye] |= prediction.x != -1000.0;
      presence.metrics[kBox3d] |= prediction.y != -1000.0;
    }
  }
  return presence;
}

bool all_have_alpha(std::span<const KittiFrame> frames) {
  return std::none_of(frames.begin(), frames.end(), [](const KittiFrame& frame) {
    return std::any_of(frame.predictions.begin(), frame.predictions.end(),
                       [](const io::KittiObject& object) { return object.alpha == -10.0; });
  });
}

std::vector<PreparedKittiFrame> prepare(std::span<const KittiFrame> frames,
                                        const KittiOptions& options) {
  std::vector<PreparedKittiFrame> prepared(frames.size());
  parallel_for(static_cast<std::int64_t>(frames.size()), kFramesAtOnce, options.threads,
               [&](std::int64_t begin, std::int64_t end) {
                 for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end);
                      ++i) {
                   require_finite(frames[i].labels, i, "label");
                   require_finite(frames[i].predictions, i, "prediction");
                   prepared[i] = prepare_kitti_frame(frames[i], options);
                 }
               });
  return prepared;
}

/// The results of one class: [metric][difficulty].
using ClassCells = std::array<std::array<TaskResult, 3>, kKittiMetrics>;

std::vector<ClassCells> run_all(const std::vector<PreparedKittiFrame>& frames,
                                const KittiOptions& options, const std::function<void()>& scored) {
  std::vector<ClassCells> cells(options.classes.size());
  static_assert(kKittiCells == kKittiMetrics * 3);
  parallel_for(static_cast<std::int64_t>(cells.size()) * kKittiCells, 1, options.threads,
               [&](std::int64_t cell, std::int64_t) {
                 const auto c = static_cast<std::size_t>(cell / kKittiCells);
                 const auto metric = static_cast<KittiMetric>(cell % kKittiCells / 3);
                 const auto difficulty = static_cast<int>(cell % 3);
                 cells[c][metric][static_cast<std::size_t>(difficulty)] =
                     run(frames, {&options.classes[c], metric, difficulty});
                 if (scored) scored();
               });
  return cells;
}

KittiCurves curves(const std::array<TaskResult, 3>& results, KittiCurve TaskResult::*curve) {
  return {results[0].*curve, results[1].*curve, results[2].*curve};
}

KittiClassResult class_result(const KittiClass& settings, const Presence& presence,
                              bool orientation, const ClassCells& cells) {
  KittiClassResult result;
  result.settings = settings;
  result.predictions = presence.predictions;
  for (std::size_t d = 0; d < 3; ++d) result.labels[d] = cells[kImage][d].labels;
  if (presence.metrics[kImage]) {
    result.image = curves(cells[kImage], &TaskResult::precision);
    if (orientation) result.orientation = curves(cells[kImage], &TaskResult::similarity);
  }
  if (presence.metrics[kBirdsEye]) {
    result.birds_eye = curves(cells[kBirdsEye], &TaskResult::precision);
  }
  if (presence.metrics[kBox3d]) result.box3d = curves(cells[kBox3d], &TaskResult::precision);
  return result;
}

}  // namespace

std::optional<KittiClass> kitti_class(std::string_view name) {
  static const std::vector<KittiClass> known = {
      {"Car", {"Van"}, {0.7, 0.7, 0.7}},       {"Pedestrian", {"Person_sitting"}, {0.5, 0.5, 0.5}},
      {"Cyclist", {}, {0.5, 0.5, 0.5}},        {"Van", {}, {0.7, 0.7, 0.7}},
      {"Person_sitting", {}, {0.5, 0.5, 0.5}}, {"Truck", {}, {0.7, 0.7, 0.7}}};
  for (const KittiClass& settings : known) {
    if (strcasecmp(settings.name.c_str(), std::string(name).c_str()) == 0) return settings;
  }
  return std::nullopt;
}

std::vector<KittiClass> kitti_benchmark_classes() {
  return {*kitti_class("Car"), *kitti_class("Pedestrian"), *kitti_class("Cyclist")};
}

double KittiCurve::r40() const {
  return 100.0 * std::accumulate(values.begin() + 1, values.end(), 0.0) / 40.0;
}

double KittiCurve::r11() const {
  double sum = 0.0;
  for (std::size_t i = 0; i < values.size(); i += 4) sum += values[i];
  return 100.0 * sum / 11.0;
}

KittiReport evaluate_kitti(std::span<const KittiFrame> frames, const KittiOptions& options,
                           const std::function<void()>& scored) {
  require_valid(options);
  const std::vector<ClassCells> cells = run_all(prepare(frames, options), options, scored);
  KittiReport report{.overlap = options.overlap,
                     .birds_eye_overlap = options.birds_eye_overlap,
                     .frames = static_cast<std::int64_t>(frames.size()),
                     .classes = {}};
  const bool orientation = all_have_alpha(frames);
  for (std::size_t c = 0; c < cells.size(); ++c) {
    const KittiClass& settings = options.classes[c];
    report.classes.push_back(
        class_result(settings, presence_of(frames, settings), orientation, cells[c]));
  }
  return report;
}

}  // namespace arbox::evaluation
