#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "arbox/io/internal/point_grid.h"
#include "arbox/io/labeled_scene.h"

namespace arbox::io::internal {

/// A mistake that labels may have, and how the box would be without it.
struct Mistake {
  std::string kind;
  /// "%" stands for the share of boxes.
  std::string text;
  std::string mend;
  /// Nothing where the box stays the same.
  std::optional<geometry::Box> (*undone)(const LabeledObject&);
};

const std::vector<Mistake>& known_mistakes();

/// How well a box fits what is around it, 0 to 1: the share of the close points that it holds,
/// times how much of its length and width they span. The lowest fifth is left out, where ground is.
double fit(const PointGrid& points, const geometry::Box& box);

/// Where the points lie that points_inside looks at.
Square around(const geometry::Box& box);

/// Points in a box, up to `enough`.
std::size_t points_inside(const PointGrid& points, const geometry::Box& box, std::size_t enough);

/// For and against one mistake, over many boxes.
struct Evidence {
  std::size_t boxes = 0, better = 0, worse = 0;
  double gain = 0.0;
  void add(const Evidence& other) {
    boxes += other.boxes, better += other.better, worse += other.worse, gain += other.gain;
  }
};

/// Evidence of one box for each of known_mistakes().
std::vector<Evidence> weigh(const PointGrid& points, const LabeledObject& object);

/// The mistake that the evidence speaks for, if any does.
std::optional<std::size_t> likely_mistake(const std::vector<Evidence>& evidence);

}  // namespace arbox::io::internal
