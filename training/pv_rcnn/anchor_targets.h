#pragma once

#include <ATen/core/Tensor.h>

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "arbox/training/scene.h"

namespace arbox::training::pv_rcnn {

/// Which anchors of one class stand for an object.
struct AnchorRule {
  /// Nearest bird's-eye IoU from which an anchor is positive, and below which it is negative.
  double positive_iou = 0.6, negative_iou = 0.45;
};

/// What the candidates of one scan shall say. Candidates are counted from 0 in each scan.
struct AnchorTargets {
  /// (N) int64: 1 positive, 0 negative, -1 ignored.
  at::Tensor kind;
  /// (P) int64, ascending: the positive candidates.
  at::Tensor positives;
  /// (P) int64: the row of the object that each of them stands for.
  at::Tensor objects;
};

/// Assigns anchors to objects, each class on its own (PV-RCNN, OpenPCDet's axis-aligned assigner).
///
/// The overlap of an anchor and an object is the IoU of their "nearest" rectangles seen from above:
/// headings are rounded to a right angle. An anchor is positive for its best object from
/// positive_iou on, and also if no candidate overlaps some object more than it does (ties within
/// 1e-9 all count), so that every object that any candidate touches has one. Of the others, those
/// below negative_iou are negative and the rest is ignored.
///
/// With ignore_similar, negative anchors that overlap an other object that resembles their class
/// (SceneObject::resembles) by at least negative_iou are ignored, too.
class AnchorAssigner {
 public:
  /// anchors (A, 7): x y z l w h yaw, in the order of the network: class (a / rotations) %
  /// rules.size(). Throws InvalidArgument for other shapes, and counts that do not divide A.
  AnchorAssigner(const at::Tensor& anchors, std::vector<AnchorRule> rules, std::int64_t rotations,
                 bool ignore_similar);

  /// candidates (N) int64: rows of the anchors. Linear in candidates of the objects' classes times
  /// objects: some milliseconds a scan. No objects make every candidate negative. Throws
  /// InvalidArgument for labels beyond the classes and candidates beyond the anchors.
  AnchorTargets assign(std::span<const SceneObject> objects, const at::Tensor& candidates) const;

 private:
  using Rectangle = std::array<double, 4>;  // low x, low y, high x, high y
  struct Candidate {
    Rectangle rectangle;
    std::int64_t row;
  };
  static Rectangle nearest_rectangle(double x, double y, double length, double width, double yaw);
  static Rectangle nearest_rectangle(const geometry::Box& box);
  static double iou(const Rectangle& first, const Rectangle& second);
  std::vector<std::vector<Candidate>> by_class(const at::Tensor& candidates) const;
  void require_labels(std::span<const SceneObject> objects) const;

  std::vector<Rectangle> rectangles_;
  std::vector<AnchorRule> rules_;
  std::int64_t rotations_;
  bool ignore_similar_;
};

}  // namespace arbox::training::pv_rcnn
