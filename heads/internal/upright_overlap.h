#pragma once

#include <array>

namespace arbox::heads::internal {

/// x y z l w h yaw.
using UprightBox = std::array<double, 7>;

struct UprightIou {
  double iou = 0.0;
  UprightBox first_gradient{}, second_gradient{};
};

/// IoU of two upright boxes and its gradient (heads/rotated_iou.h).
UprightIou upright_iou(const UprightBox& first, const UprightBox& second);

}  // namespace arbox::heads::internal
