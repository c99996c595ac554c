#include "arbox/evaluation/uncertainty_protocol.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <set>

#include "arbox/base/error.h"
#include "arbox/evaluation/center_matching.h"
#include "arbox/evaluation/internal/judged_detection.h"
#include "arbox/evaluation/ranking.h"
#include "arbox/geometry/quantile_box.h"

namespace arbox::evaluation {
namespace {

using geometry::Detection;
using internal::JudgedBox;
using internal::JudgedDetection;

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
  /// One a box whose detection has an uncertainty; `wrong_chance` of those that also have samples.
  std::vector<double> uncertainty, uncertain_iou, wrong_chance;
  std::vector<bool> uncertain_wrong;

  void add(const JudgedBox& box, const std::optional<double>& of_detection,
           const UncertaintyOptions& options) {
    const bool is_wrong = box.iou < options.wrong_iou;
    ++boxes;
    iou += box.iou;
    wrong += is_wrong ? 1 : 0;
    if (!of_detection) return;
    uncertainty.push_back(*of_detection);
    uncertain_iou.push_back(box.iou);
    uncertain_wrong.push_back(is_wrong);
    if (box.wrong_chance) wrong_chance.push_back(*box.wrong_chance);
  }

  void add_expected(RankedBoxes& figures) const {
    if (wrong_chance.empty() || wrong_chance.size() != uncertainty.size()) return;
    figures.chance_roc_auc = roc_auc(wrong_chance, uncertain_wrong);
    figures.expected = {.wrong = std::accumulate(wrong_chance.begin(), wrong_chance.end(), 0.0),
                        .roc_auc = expected_roc_auc(uncertainty, wrong_chance),
                        .chance_roc_auc = expected_roc_auc(wrong_chance, wrong_chance)};
  }

  RankedBoxes figures() const {
    RankedBoxes result{.boxes = boxes,
                       .wrong = wrong,
                       .mean_iou = iou / static_cast<double>(std::max<std::size_t>(boxes, 1)),
                       .roc_auc = roc_auc(uncertainty, uncertain_wrong),
                       .spearman = spearman_correlation(uncertainty, uncertain_iou),
                       .chance_roc_auc = {},
                       .expected = {}};
    add_expected(result);
    return result;
  }
};

/// Boxes of one level, and how many of them contain their object.
struct Level {
  Ranking ranking;
  std::size_t contained = 0, sampled = 0;
  double held = 0.0;

  void add(const JudgedBox& box, const std::optional<double>& uncertainty,
           const UncertaintyOptions& options) {
    ranking.add(box, uncertainty, options);
    contained += box.iog > options.min_iog ? 1 : 0;
    sampled += box.held_share ? 1 : 0;
    held += box.held_share.value_or(0.0);
  }
};

/// What samples say of the overlap of their detections' boxes.
struct OverlapSums {
  std::size_t boxes = 0;
  std::vector<double> promised, kept;

  void add(const JudgedDetection& detection, const UncertaintyOptions& options) {
    const std::vector<double>& shares = detection.overlap_shares;
    if (shares.empty()) return;
    promised.resize(shares.size());
    kept.resize(shares.size());
    ++boxes;
    for (std::size_t i = 0; i < shares.size(); ++i) {
      promised[i] += shares[i];
      kept[i] += detection.own.iou >= options.promised_ious[i] ? 1.0 : 0.0;
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

/// What the figures of a class are made of.
struct Sums {
  std::size_t objects = 0;
  double iog = 0.0, f1 = 0.0;
  Ranking own;
  std::map<double, Level> quantile, sampled, confidence;
  OverlapSums overlaps;

  void add(const JudgedDetection& detection, const UncertaintyOptions& options) {
    own.add(detection.own, detection.uncertainty, options);
    overlaps.add(detection, options);
    iog += detection.own.iog;
    f1 += detection.own.f1;
    const auto add_to = [&](std::map<double, Level>& levels, const std::vector<JudgedBox>& boxes) {
      for (const JudgedBox& box : boxes) {
        levels[box.level].add(box, detection.uncertainty, options);
      }
    };
    add_to(quantile, detection.quantile_boxes);
    add_to(sampled, detection.sample_boxes);
    add_to(confidence, detection.confidence_boxes);
  }
};

std::vector<BoxLevel> box_levels(const std::map<double, Level>& levels, bool quantiles) {
  std::vector<BoxLevel> result;
  for (const auto& [level, sums] : levels) {
    const double boxes = static_cast<double>(sums.ranking.boxes);
    BoxLevel& figures = result.emplace_back(BoxLevel{sums.ranking.figures()});
    figures.level = level;
    figures.promised = quantiles ? 1.0 - level : level;
    figures.contained = static_cast<double>(sums.contained) / boxes;
    if (sums.sampled == sums.ranking.boxes) figures.held = sums.held / boxes;
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
      const JudgedDetection judged = internal::judge(detection, object, options);
      of_class->second.add(judged, options);
      all.add(judged, options);
      report.found.push_back({.label = object.label,
                              .iou = judged.own.iou,
                              .iog = judged.own.iog,
                              .uncertainty = judged.uncertainty});
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
