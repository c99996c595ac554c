#include "arbox/evaluation/recall.h"

#include <algorithm>
#include <cmath>

#include "arbox/base/error.h"
#include "arbox/evaluation/internal/kitti_matching.h"

namespace arbox::evaluation {
namespace {

using io::KittiObject;

/// Rows of the objects that are wanted.
std::vector<Eigen::Index> rows_of(const std::vector<KittiObject>& objects, const auto& wanted) {
  std::vector<Eigen::Index> rows;
  for (std::size_t i = 0; i < objects.size(); ++i) {
    if (wanted(objects[i])) rows.push_back(static_cast<Eigen::Index>(i));
  }
  return rows;
}

bool is_plain(const KittiObject& label, const RecallOptions& options) {
  return label.type == options.label && std::hypot(label.x, label.z) <= options.max_range &&
         label.occlusion >= 0 && label.occlusion <= options.max_occlusion &&
         label.truncation <= options.max_truncation;
}

void require_options(const RecallOptions& options) {
  for (const double overlap : options.overlaps) {
    if (overlap > 0.0 && overlap <= 1.0) continue;
    throw InvalidArgument("evaluate_recall: expected overlaps above 0 and up to 1, got " +
                          std::to_string(overlap));
  }
}

}  // namespace

double RecallReport::false_per_frame() const {
  return static_cast<double>(false_detections) /
         static_cast<double>(std::max<std::size_t>(frames, 1));
}

RecallReport evaluate_recall(std::span<const KittiFrame> frames, const RecallOptions& options) {
  require_options(options);
  RecallReport report{.options = options, .frames = frames.size(), .found = {}};
  for (const double overlap : options.overlaps) report.found.push_back({.overlap = overlap});
  for (const KittiFrame& frame : frames) {
    const PreparedKittiFrame prepared = prepare_kitti_frame(frame, {});
    const Eigen::MatrixXd& overlaps = prepared.overlaps[kBox3d];
    const auto detections = rows_of(frame.predictions, [&](const KittiObject& one) {
      return one.type == options.label && one.score >= options.min_score;
    });
    const auto objects =
        rows_of(frame.labels, [&](const KittiObject& label) { return is_plain(label, options); });
    const auto resembling = rows_of(frame.labels, [&](const KittiObject& label) {
      return std::find(options.resembling.begin(), options.resembling.end(), label.type) !=
             options.resembling.end();
    });
    report.objects += objects.size();
    report.detections += detections.size();
    for (const Eigen::Index object : objects) {
      double best = 0.0;
      for (const Eigen::Index one : detections) best = std::max(best, overlaps(one, object));
      for (FoundShare& share : report.found) share.found += best >= share.overlap ? 1 : 0;
    }
    for (const Eigen::Index one : detections) {
      double best = 0.0;
      for (const Eigen::Index label : resembling) best = std::max(best, overlaps(one, label));
      const bool is_false =
          best < options.false_overlap &&
          prepared.dont_care_share[static_cast<std::size_t>(one)] <= options.dont_care_share;
      report.false_detections += is_false ? 1 : 0;
    }
  }
  for (FoundShare& share : report.found) {
    share.recall = static_cast<double>(share.found) /
                   static_cast<double>(std::max<std::size_t>(report.objects, 1));
    share.interval = share_interval(share.found, report.objects);
  }
  return report;
}

}  // namespace arbox::evaluation
