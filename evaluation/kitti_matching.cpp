#include "arbox/evaluation/internal/kitti_matching.h"

#include <strings.h>

#include <algorithm>
#include <cmath>

#include "arbox/io/kitti_label.h"

namespace arbox::evaluation {
namespace {

using geometry::Box;
using geometry::Overlap;
using geometry::OverlapSpace;
using io::KittiObject;

struct DifficultyLimits {
  int min_height;
  int max_occlusion;
  double max_truncation;
};
constexpr std::array<DifficultyLimits, 3> kLimits = {{{40, 0, 0.15}, {25, 1, 0.30}, {25, 2, 0.50}}};

bool same_name(const std::string& first, const std::string& second) {
  return first.size() == second.size() && strcasecmp(first.c_str(), second.c_str()) == 0;
}

double image_area(const KittiObject& object) {
  return (object.right - object.left) * (object.bottom - object.top);
}

double image_intersection(const KittiObject& first, const KittiObject& second) {
  const double width = std::min(first.right, second.right) - std::max(first.left, second.left);
  const double height = std::min(first.bottom, second.bottom) - std::max(first.top, second.top);
  return width > 0.0 && height > 0.0 ? width * height : 0.0;
}

double image_iou(const KittiObject& first, const KittiObject& second) {
  const double shared = image_intersection(first, second);
  return shared > 0.0 ? shared / (image_area(first) + image_area(second) - shared) : 0.0;
}

Eigen::MatrixXd image_overlaps(const KittiFrame& frame) {
  Eigen::MatrixXd result(frame.predictions.size(), frame.labels.size());
  for (Eigen::Index i = 0; i < result.rows(); ++i) {
    for (Eigen::Index j = 0; j < result.cols(); ++j) {
      result(i, j) = image_iou(frame.predictions[i], frame.labels[j]);
    }
  }
  return result;
}

struct BoxRows {
  std::vector<Box> boxes;
  std::vector<Eigen::Index> rows;
};

// The camera frame with y turned up: x stays, z becomes y, so that rotation_y turns the other way.
BoxRows boxes_of(const std::vector<KittiObject>& objects) {
  BoxRows result;
  for (std::size_t row = 0; row < objects.size(); ++row) {
    const KittiObject& object = objects[row];
    if (!io::has_box(object)) continue;
    result.boxes.push_back(
        geometry::make_yaw_box({object.x, object.z, 0.5 * object.height - object.y},
                               {object.length, object.width, object.height}, -object.rotation_y));
    result.rows.push_back(static_cast<Eigen::Index>(row));
  }
  return result;
}

Eigen::MatrixXd box_overlaps(const KittiFrame& frame, const BoxRows& predictions,
                             const BoxRows& labels, Overlap measure, OverlapSpace space) {
  Eigen::MatrixXd result = Eigen::MatrixXd::Zero(frame.predictions.size(), frame.labels.size());
  const auto overlaps = geometry::overlap_matrix(
      predictions.boxes, labels.boxes, {.measure = measure, .space = space, .threads = 1});
  for (Eigen::Index i = 0; i < overlaps.rows(); ++i) {
    for (Eigen::Index j = 0; j < overlaps.cols(); ++j) {
      result(predictions.rows[i], labels.rows[j]) = overlaps(i, j);
    }
  }
  return result;
}

std::vector<double> dont_care_shares(const KittiFrame& frame) {
  std::vector<double> shares(frame.predictions.size(), 0.0);
  for (const KittiObject& region : frame.labels) {
    if (!same_name(region.type, "DontCare")) continue;
    for (std::size_t i = 0; i < shares.size(); ++i) {
      const double shared = image_intersection(frame.predictions[i], region);
      if (shared > 0.0) {
        shares[i] = std::max(shares[i], shared / image_area(frame.predictions[i]));
      }
    }
  }
  return shares;
}

bool is_neighbour(const KittiClass& settings, const std::string& type) {
  return std::any_of(settings.neighbours.begin(), settings.neighbours.end(),
                     [&](const std::string& name) { return same_name(name, type); });
}

bool too_hard(const KittiObject& label, const DifficultyLimits& limits) {
  return label.occlusion > limits.max_occlusion || label.truncation > limits.max_truncation ||
         label.bottom - label.top <= limits.min_height;
}

// The official kit keeps a prediction's height as an integer before it compares.
bool too_small(const KittiObject& prediction, const DifficultyLimits& limits) {
  return std::trunc(std::abs(prediction.top - prediction.bottom)) < limits.min_height;
}

}  // namespace

int kitti_difficulty(const KittiObject& label) {
  for (std::size_t i = 0; i < kLimits.size(); ++i) {
    if (!too_hard(label, kLimits[i])) return static_cast<int>(i);
  }
  return -1;
}

PreparedKittiFrame prepare_kitti_frame(const KittiFrame& frame, const KittiOptions& options) {
  PreparedKittiFrame result;
  result.frame = &frame;
  const BoxRows predictions = boxes_of(frame.predictions);
  const BoxRows labels = boxes_of(frame.labels);
  result.overlaps[kImage] = image_overlaps(frame);
  result.overlaps[kBirdsEye] =
      box_overlaps(frame, predictions, labels, options.birds_eye_overlap, OverlapSpace::kBirdsEye);
  result.overlaps[kBox3d] =
      box_overlaps(frame, predictions, labels, options.overlap, OverlapSpace::k3d);
  result.dont_care_share = dont_care_shares(frame);
  return result;
}

double KittiTask::min_overlap() const {
  const KittiThresholds& thresholds = settings->min_overlap;
  return metric == kImage ? thresholds.image
                          : (metric == kBirdsEye ? thresholds.birds_eye : thresholds.box3d);
}

KittiMatching::KittiMatching(const PreparedKittiFrame& prepared, const KittiTask& task) {
  const DifficultyLimits& limits = kLimits[static_cast<std::size_t>(task.difficulty)];
  const Eigen::MatrixXd& overlaps = prepared.overlaps[task.metric];
  const double min_overlap = task.min_overlap();
  std::vector<Eigen::Index> rows;
  for (std::size_t i = 0; i < prepared.frame->predictions.size(); ++i) {
    const KittiObject& prediction = prepared.frame->predictions[i];
    const bool ignored = too_small(prediction, limits);
    if (!ignored && !same_name(prediction.type, task.settings->name)) continue;
    predictions_.push_back(
        {.score = prediction.score,
         .alpha = prediction.alpha,
         .ignored = ignored,
         .in_dont_care = task.metric == kImage && prepared.dont_care_share[i] > min_overlap});
    rows.push_back(static_cast<Eigen::Index>(i));
  }
  for (std::size_t j = 0; j < prepared.frame->labels.size(); ++j) {
    const KittiObject& object = prepared.frame->labels[j];
    const bool of_class = same_name(object.type, task.settings->name);
    if (!of_class && !is_neighbour(*task.settings, object.type)) continue;
    Label label{
        .alpha = object.alpha, .ignored = !of_class || too_hard(object, limits), .candidates = {}};
    for (std::size_t k = 0; k < rows.size(); ++k) {
      const double overlap = overlaps(rows[k], static_cast<Eigen::Index>(j));
      if (overlap > min_overlap) label.candidates.push_back({static_cast<int>(k), overlap});
    }
    valid_labels_ += !label.ignored;
    labels_.push_back(std::move(label));
  }
}

bool KittiMatching::has_predictions() const {
  return std::any_of(predictions_.begin(), predictions_.end(),
                     [](const Prediction& prediction) { return !prediction.ignored; });
}

void KittiMatching::collect_scores(std::vector<double>& scores) const {
  std::vector<char> taken(predictions_.size(), 0);
  for (const Label& label : labels_) {
    int best = -1;
    for (const Candidate& candidate : label.candidates) {
      if (taken[candidate.prediction]) continue;
      if (best < 0 || predictions_[candidate.prediction].score > predictions_[best].score) {
        best = candidate.prediction;
      }
    }
    if (best < 0) continue;
    taken[best] = 1;
    if (!label.ignored && !predictions_[best].ignored) scores.push_back(predictions_[best].score);
  }
}

// Ignored predictions take labels only when nothing else does, and such a match counts nowhere, so
// they are left out here.
KittiMatching::Counts KittiMatching::count(double threshold) const {
  Counts counts;
  std::vector<char> taken(predictions_.size(), 0);
  const auto takes_part = [&](int i) {
    return !taken[i] && !predictions_[i].ignored && predictions_[i].score >= threshold;
  };
  for (const Label& label : labels_) {
    const Candidate* best = nullptr;
    for (const Candidate& candidate : label.candidates) {
      if (takes_part(candidate.prediction) && (!best || candidate.overlap > best->overlap)) {
        best = &candidate;
      }
    }
    if (!best) continue;
    taken[best->prediction] = 1;
    if (label.ignored) continue;
    ++counts.true_positives;
    counts.similarity += 0.5 * (1.0 + std::cos(label.alpha - predictions_[best->prediction].alpha));
  }
  for (std::size_t i = 0; i < predictions_.size(); ++i) {
    counts.false_positives += takes_part(static_cast<int>(i)) && !predictions_[i].in_dont_care;
  }
  return counts;
}

}  // namespace arbox::evaluation
