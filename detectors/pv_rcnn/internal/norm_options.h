#pragma once

namespace arbox::detectors::pv_rcnn::internal {

/// Batch norms of both backbones; those of the other stages have the defaults.
inline constexpr double kBackboneEpsilon = 1e-3;

}  // namespace arbox::detectors::pv_rcnn::internal
