#pragma once

#include "arbox/geometry/overlap.h"

namespace arbox::detectors {

inline double birds_eye_iou(const geometry::Box& one, const geometry::Box& other) {
  return geometry::overlap(one, other, {.space = geometry::OverlapSpace::kBirdsEye});
}

}  // namespace arbox::detectors
