#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "arbox/geometry/detection.h"

namespace arbox::evaluation {

/// A detection and the object that it found, by their places in the lists.
struct CenterMatch {
  std::size_t detection = 0;
  std::size_t object = 0;
};

/// Which detection found which object, by centres rather than overlap, so that what is then asked
/// of the boxes (do they contain the object?) does not decide who is asked.
///
/// Detections choose in the order of their scores, best first, ties by place: each takes the
/// nearest object of its own class that is still free and at most `max_distance` metres away,
/// centre to centre. The matches come in that order; each detection and each object is in one at
/// most. The objects' scores are not looked at. Empty lists give no matches. Throws InvalidArgument
/// for scores or centres that are not finite, and unless max_distance is above 0. Cost: detections
/// times objects.
std::vector<CenterMatch> match_by_center(std::span<const geometry::Detection> detections,
                                         std::span<const geometry::Detection> objects,
                                         double max_distance = 2.0);

}  // namespace arbox::evaluation
