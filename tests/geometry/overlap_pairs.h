#pragma once

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "arbox/base/random.h"
#include "arbox/geometry/box.h"

/// \file
/// Families of box pairs that overlap tests run over.

namespace arbox::testing {

using BoxPair = std::pair<geometry::Box, geometry::Box>;

struct PairFamily {
  std::string name;
  std::function<BoxPair(const RandomStream&)> make;
};

/// Pairs in general position, most of them overlapping: yaw and yaw, yaw and free, free and free.
std::vector<PairFamily> random_families();

/// Pairs that break careless code: identical, equivalent, touching, nested, nearly coplanar, edge
/// to edge, thin, large and far boxes, of both kinds.
std::vector<PairFamily> degenerate_families();

/// Draws 0 to 9 of the stream.
geometry::Box random_box(const RandomStream& stream, bool free_rotation, double spread = 1.5,
                         double smallest = 0.2, double largest = 4.0);

}  // namespace arbox::testing
