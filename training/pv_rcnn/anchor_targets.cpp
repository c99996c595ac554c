#include "arbox/training/pv_rcnn/anchor_targets.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <utility>

#include "arbox/base/error.h"
#include "arbox/geometry/box.h"
#include "arbox/training/internal/tensors.h"

namespace arbox::training::pv_rcnn {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kTie = 1e-9;

enum Kind : std::int64_t { kIgnored = -1, kNegative = 0, kPositive = 1 };

struct Touch {
  std::int64_t row;
  double iou;
};

}  // namespace

AnchorAssigner::Rectangle AnchorAssigner::nearest_rectangle(double x, double y, double length,
                                                            double width, double yaw) {
  const double turned = std::abs(std::remainder(yaw, kPi));
  if (turned >= 0.25 * kPi) std::swap(length, width);
  return {x - 0.5 * length, y - 0.5 * width, x + 0.5 * length, y + 0.5 * width};
}

AnchorAssigner::Rectangle AnchorAssigner::nearest_rectangle(const geometry::Box& box) {
  return nearest_rectangle(box.center.x(), box.center.y(), box.size.x(), box.size.y(),
                           geometry::yaw(box));
}

double AnchorAssigner::iou(const Rectangle& first, const Rectangle& second) {
  const double width = std::min(first[2], second[2]) - std::max(first[0], second[0]);
  const double height = std::min(first[3], second[3]) - std::max(first[1], second[1]);
  if (width <= 0 || height <= 0) return 0.0;
  const auto area = [](const Rectangle& one) { return (one[2] - one[0]) * (one[3] - one[1]); };
  return width * height / (area(first) + area(second) - width * height);
}

AnchorAssigner::AnchorAssigner(const at::Tensor& anchors, std::vector<AnchorRule> rules,
                               std::int64_t rotations, bool ignore_similar)
    : rules_(std::move(rules)), rotations_(rotations), ignore_similar_(ignore_similar) {
  const auto cell = static_cast<std::int64_t>(rules_.size()) * rotations_;
  if (anchors.dim() != 2 || anchors.size(1) != 7 || cell < 1 ||
      anchors.size(0) % std::max<std::int64_t>(cell, 1) != 0) {
    throw InvalidArgument("anchor assigner: expected anchors (cells * classes * rotations, 7) of " +
                          std::to_string(rules_.size()) + " classes and " +
                          std::to_string(rotations_) + " rotations, got " +
                          internal::shape_text(anchors));
  }
  const at::Tensor rows = internal::double_rows(anchors);
  const double* row = rows.data_ptr<double>();
  for (std::int64_t i = 0; i < rows.size(0); ++i, row += 7) {
    rectangles_.push_back(nearest_rectangle(row[0], row[1], row[3], row[4], row[6]));
  }
}

std::vector<std::vector<AnchorAssigner::Candidate>> AnchorAssigner::by_class(
    const at::Tensor& candidates) const {
  std::vector<std::vector<Candidate>> result(rules_.size());
  const at::Tensor rows = candidates.to(at::kCPU, at::kLong).contiguous();
  const std::int64_t* anchors = rows.data_ptr<std::int64_t>();
  for (std::int64_t i = 0; i < rows.numel(); ++i) {
    if (anchors[i] < 0 || anchors[i] >= static_cast<std::int64_t>(rectangles_.size())) {
      throw InvalidArgument("anchor targets: candidate " + std::to_string(i) +
                            ": expected one of " + std::to_string(rectangles_.size()) +
                            " anchors, got " + std::to_string(anchors[i]));
    }
    const auto label = (anchors[i] / rotations_) % static_cast<std::int64_t>(rules_.size());
    result[label].push_back({rectangles_[anchors[i]], i});
  }
  return result;
}

void AnchorAssigner::require_labels(std::span<const SceneObject> objects) const {
  for (std::size_t i = 0; i < objects.size(); ++i) {
    const int label = std::max(objects[i].label, objects[i].resembles);
    if (label < static_cast<int>(rules_.size())) continue;
    throw InvalidArgument("anchor targets: object " + std::to_string(i) +
                          ": expected a label below " + std::to_string(rules_.size()) + ", got " +
                          std::to_string(label));
  }
}

namespace {

/// What is known of each candidate while objects are looked at one after the other.
struct Assignment {
  explicit Assignment(std::int64_t count)
      : best(count, 0.0), object(count, -1), kind(count, kNegative) {}
  std::vector<double> best;
  std::vector<std::int64_t> object, kind;
  std::vector<std::int64_t> forced;

  /// `touched`: the candidates that object number `index` overlaps.
  void add(std::int64_t index, const std::vector<Touch>& touched) {
    double highest = 0.0;
    for (const Touch& touch : touched) {
      highest = std::max(highest, touch.iou);
      if (touch.iou <= best[touch.row]) continue;
      best[touch.row] = touch.iou;
      object[touch.row] = index;
    }
    for (const Touch& touch : touched) {
      if (touch.iou >= highest - kTie) forced.push_back(touch.row);
    }
  }

  AnchorTargets targets() const {
    std::vector<std::int64_t> positives, objects;
    for (std::size_t row = 0; row < kind.size(); ++row) {
      if (kind[row] != kPositive) continue;
      positives.push_back(static_cast<std::int64_t>(row));
      objects.push_back(object[row]);
    }
    return {internal::to_tensor(kind), internal::to_tensor(positives),
            internal::to_tensor(objects)};
  }
};

}  // namespace

AnchorTargets AnchorAssigner::assign(std::span<const SceneObject> objects,
                                     const at::Tensor& candidates) const {
  require_labels(objects);
  const auto classes = by_class(candidates);
  const auto touched_by = [&](const geometry::Box& box, int label) {
    const Rectangle rectangle = nearest_rectangle(box);
    std::vector<Touch> touched;
    for (const Candidate& candidate : classes[label]) {
      const double overlap = iou(candidate.rectangle, rectangle);
      if (overlap > 0) touched.push_back({candidate.row, overlap});
    }
    return touched;
  };
  Assignment assignment(candidates.numel());
  for (std::size_t i = 0; i < objects.size(); ++i) {
    if (objects[i].label < 0) continue;
    assignment.add(static_cast<std::int64_t>(i), touched_by(objects[i].box, objects[i].label));
  }
  for (std::size_t label = 0; label < classes.size(); ++label) {
    const AnchorRule& rule = rules_[label];
    for (const auto& [rectangle, row] : classes[label]) {
      const double best = assignment.best[row];
      if (best >= rule.negative_iou) assignment.kind[row] = kIgnored;
      if (best > 0 && best >= rule.positive_iou) assignment.kind[row] = kPositive;
    }
  }
  for (const std::int64_t row : assignment.forced) assignment.kind[row] = kPositive;
  for (const SceneObject& object : objects) {
    if (!ignore_similar_ || object.label >= 0 || object.resembles < 0) continue;
    for (const Touch& touch : touched_by(object.box, object.resembles)) {
      const bool like = touch.iou >= rules_[object.resembles].negative_iou;
      if (like && assignment.kind[touch.row] == kNegative) assignment.kind[touch.row] = kIgnored;
    }
  }
  return assignment.targets();
}

}  // namespace arbox::training::pv_rcnn
