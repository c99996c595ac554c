#include "arbox/evaluation/uncertainty_protocol.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "arbox/base/error.h"
#include "arbox/evaluation/box_estimation.h"
#include "arbox/evaluation/center_matching.h"
#include "arbox/evaluation/ranking.h"
#include "arbox/geometry/confidence_box.h"
#include "arbox/geometry/overlap.h"

namespace arbox::evaluation {
namespace {

using geometry::Detection;

void require_options(const UncertaintyOptions& options) {
  const auto require_share = [](double value, const char* name) {
    if (value >= 0.0 && value <= 1.0) return;
    throw InvalidArgument(std::string("evaluate_uncertainty: expected ") + name +
                          " from 0 to 1, got " + std::to_string(value));
  };
  require_share(options.min_score, "min_score");
  require_share(options.min_iog, "min_iog");
  require_share(options.wrong_iou, "wrong_iou");
  for (const double iou : options.promised_ious) require_share(iou, "promised_ious");
}

/// Boxes of one kind, and the uncertainty of their detections.
struct Ranking {
  std::size_t boxes = 0, wrong = 0;
  double iou = 0.0;
  std::vector<double> uncertainty, uncertain_iou;
  std::vector<bool> uncertain_wrong;

  void add(double overlap, const std::optional<double>& of_detection,
           const UncertaintyOptions& options) {
    const bool is_wrong = overlap < options.wrong_iou;
    ++boxes;
    iou += overlap;
    wrong += is_wrong ? 1 : 0;
    if (!of_detection) return;
    uncertainty.push_back(*of_detection);
    uncertain_iou.push_back(overlap);
    uncertain_wrong.push_back(is_wrong);
  }

  RankedBoxes figures() const {
    return {.boxes = boxes,
            .wrong = wrong,
            .mean_iou = iou / static_cast<double>(std::max<std::size_t>(boxes, 1)),
            .roc_auc = roc_auc(uncertainty, uncertain_wrong),
            .spearman = spearman_correlation(uncertainty, uncertain_iou)};
  }
};

/// Boxes of one level, and how many of them contain their object.
struct Level {
  Ranking ranking;
  std::size_t contained = 0;

  void add(const geometry::Box& box, const geometry::Box& object,
           const std::optional<double>& uncertainty, const UncertaintyOptions& options) {
    ranking.add(geometry::overlap(box, object), uncertainty, options);
    const double covered = geometry::overlap(box, object, {.measure = geometry::Overlap::kIog});
    contained += covered > options.min_iog ? 1 : 0;
  }
};

/// What samples say of the overlap of their detections' boxes.
struct OverlapSums {
  std::size_t boxes = 0;
  std::vector<double> promised, kept;

  void add(const Detection& detection, double overlap, const UncertaintyOptions& options) {
    if (detection.samples.empty()) return;
    const std::vector<double>& ious = options.promised_ious;
    promised.resize(ious.size());
    kept.resize(ious.size());
    ++boxes;
    for (std::size_t i = 0; i < ious.size(); ++i) {
      promised[i] +=
          geometry::overlapping_share({.boxes = detection.samples}, detection.box, ious[i]);
      kept[i] += overlap >= ious[i] ? 1.0 : 0.0;
    }
  }

  std::vector<PromisedOverlap> figures(const UncertaintyOptions& options) const {
    std::vector<PromisedOverlap> result;
    const auto count = static_cast<double>(boxes);
    for (std::size_t i = 0; i < promised.size(); ++i) {
      result.push_back({.iou = options.promised_ious[i],
                        .promised = promised[i] / count,
                        .kept = kept[i] / count,
                        .boxes = boxes});
    }
    return result;
  }
};

void require_finite(const std::optional<double>& uncertainty) {
  if (!uncertainty || std::isfinite(*uncertainty)) return;
  throw InvalidArgument("evaluate_uncertainty: expected a finite uncertainty, got " +
                        std::to_string(*uncertainty));
}

/// What the figures of a class are made of.
struct Sums {
  std::size_t objects = 0;
  double iog = 0.0, f1 = 0.0;
  Ranking own;
  std::map<double, Level> quantile, sampled, confidence;
  OverlapSums overlaps;

  void add(const Detection& detection, const Detection& object, const BoxError& error,
           std::span<const geometry::ConfidenceBox> sample_boxes,
           const UncertaintyOptions& options) {
    const auto& uncertainty = detection.uncertainty;
    require_finite(uncertainty);
    own.add(error.iou, uncertainty, options);
    overlaps.add(detection, error.iou, options);
    iog += error.iog;
    f1 += error.f1;
    const auto add_to = [&](Level& level, const geometry::Box& box) {
      level.add(box, object.box, uncertainty, options);
    };
    for (const auto& box : detection.quantile_boxes) add_to(quantile[box.q], box.box);
    for (const auto& box : detection.confidence_boxes) add_to(confidence[box.p], box.box);
    for (const auto& box : sample_boxes) add_to(sampled[box.p], box.box);
  }
};

std::vector<geometry::ConfidenceBox> sample_boxes(const Detection& detection,
                                                  const UncertaintyOptions& options) {
  if (detection.samples.empty() || options.sample_confidences.empty()) return {};
  return geometry::confidence_boxes({.boxes = detection.samples}, options.sample_confidences);
}

std::vector<BoxLevel> box_levels(const std::map<double, Level>& levels, bool quantiles) {
  std::vector<BoxLevel> result;
  for (const auto& [level, sums] : levels) {
    const double boxes = static_cast<double>(sums.ranking.boxes);
    BoxLevel& figures = result.emplace_back(BoxLevel{sums.ranking.figures()});
    figures.level = level;
    figures.promised = quantiles ? 1.0 - level : level;
    figures.contained = static_cast<double>(sums.contained) / boxes;
  }
  return result;
}

UncertaintyFigures figures_of(const std::string& label, const Sums& sums,
                              const UncertaintyOptions& options) {
  UncertaintyFigures figures;
  figures.label = label;
  figures.objects = sums.objects;
  figures.found = sums.own.figures();
  const auto count = static_cast<double>(std::max<std::size_t>(figures.found.boxes, 1));
  figures.mean_iog = sums.iog / count;
  figures.mean_f1 = sums.f1 / count;
  const double both = figures.found.mean_iou + figures.mean_iog;
  figures.f1_of_means = both > 0 ? 2.0 * figures.found.mean_iou * figures.mean_iog / both : 0.0;
  figures.quantile_boxes = box_levels(sums.quantile, true);
  figures.sample_boxes = box_levels(sums.sampled, false);
  figures.confidence_boxes = box_levels(sums.confidence, false);
  figures.overlaps = sums.overlaps.figures(options);
  return figures;
}

std::vector<std::string> classes_of(std::span<const UncertaintyScan> scans,
                                    const UncertaintyOptions& options) {
  if (!options.classes.empty()) return options.classes;
  std::set<std::string> names;
  for (const UncertaintyScan& scan : scans) {
    for (const Detection& object : scan.objects) names.insert(object.label);
  }
  return {names.begin(), names.end()};
}

}  // namespace

UncertaintyReport evaluate_uncertainty(std::span<const UncertaintyScan> scans,
                                       const UncertaintyOptions& options) {
  require_options(options);
  UncertaintyReport report{
      .options = options, .scans = scans.size(), .classes = {}, .all = {}, .found = {}};
  const std::vector<std::string> classes = classes_of(scans, options);
  std::map<std::string, Sums> sums;
  for (const std::string& label : classes) sums[label];
  Sums all;
  for (const UncertaintyScan& scan : scans) {
    std::vector<Detection> detections;
    std::copy_if(scan.detections.begin(), scan.detections.end(), std::back_inserter(detections),
                 [&](const Detection& one) { return one.score >= options.min_score; });
    for (const Detection& object : scan.objects) {
      const auto of_class = sums.find(object.label);
      if (of_class == sums.end()) continue;
      ++of_class->second.objects;
      ++all.objects;
    }
    for (const auto& match : match_by_center(detections, scan.objects, options.max_distance)) {
      const Detection& detection = detections[match.detection];
      const Detection& object = scan.objects[match.object];
      const auto of_class = sums.find(object.label);
      if (of_class == sums.end()) continue;
      const BoxError error =
          box_error(detection.box, object.box, geometry::BoxSymmetry::kHalfTurns);
      const auto sampled = sample_boxes(detection, options);
      of_class->second.add(detection, object, error, sampled, options);
      all.add(detection, object, error, sampled, options);
      report.found.push_back({.label = object.label,
                              .iou = error.iou,
                              .iog = error.iog,
                              .uncertainty = detection.uncertainty});
    }
  }
  for (const std::string& label : classes) {
    report.classes.push_back(figures_of(label, sums[label], options));
  }
  report.all = figures_of("all", all, options);
  return report;
}

void use_gaussian_uncertainty(std::span<Detection> detections) {
  for (Detection& detection : detections) {
    if (detection.samples.empty()) {
      throw InvalidArgument(
          "use_gaussian_uncertainty: expected box samples with every detection, got none; ask the "
          "detector for them");
    }
    detection.uncertainty =
        geometry::gaussian_uncertainty({.boxes = detection.samples, .weights = {}, .object = 0});
  }
}

ShareInterval share_interval(std::size_t hits, std::size_t trials) {
  if (trials == 0) return {};
  constexpr double kDeviations = 1.959963984540054;
  const auto n = static_cast<double>(trials);
  const double share = static_cast<double>(hits) / n;
  const double square = kDeviations * kDeviations;
  const double middle = share + square / (2.0 * n);
  const double reach = kDeviations * std::sqrt(share * (1.0 - share) / n + square / (4.0 * n * n));
  const double scale = 1.0 + square / n;
  return {.low = std::max((middle - reach) / scale, 0.0),
          .high = std::min((middle + reach) / scale, 1.0)};
}

}  // namespace arbox::evaluation
