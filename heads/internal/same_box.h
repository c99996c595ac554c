#pragma once

#include <vector>

#include "arbox/geometry/box.h"

namespace arbox::heads::internal {

/// A box with a log density.
struct WeighedBox {
  geometry::Box box;
  double log_density = 0.0;
};

/// log(exp(a) + exp(b)); either may be -infinity.
double log_sum(double a, double b);

/// Whether two boxes are the same solid: every corner of one within `tolerance` metres of a corner
/// of the other.
bool same_solid(const geometry::Box& first, const geometry::Box& second, double tolerance);

/// The boxes without repetitions of the same solid (within `tolerance` diagonals), most likely
/// first: the densities of repetitions are added to the most likely of them.
std::vector<WeighedBox> merged(std::vector<WeighedBox> boxes, double tolerance);

}  // namespace arbox::heads::internal
