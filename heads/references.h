#pragma once

#include <ATen/core/Tensor.h>

namespace arbox::heads {

/// The frame that each object's box is described in, one row an object. The tensors keep their
/// gradient: a detector may predict them (FCAF3D's scale is a network output).
///
/// | detector       | origin          | rotation | size                  |
/// |----------------|-----------------|----------|-----------------------|
/// | PV-RCNN        | RoI centre      | RoI yaw  | RoI size              |
/// | FCAF3D style   | voxel location  | identity | (s, s, s)             |
/// | crop estimator | quartile centre | identity | (s, s, s)             |
struct References {
  at::Tensor origin;    ///< (N, 3), metres.
  at::Tensor rotation;  ///< (N, 4) unit quaternions, w first.
  at::Tensor size;      ///< (N, 3), metres, above zero.

  std::int64_t count() const { return origin.defined() ? origin.size(0) : 0; }

  /// The rows of `index` (int64, (K)).
  References select(const at::Tensor& index) const;

  /// The same numbers without gradient.
  References detached(at::ScalarType type = at::kFloat) const;

  /// Throws InvalidArgument, naming `where` and the shapes, unless origin (N, 3), rotation (N, 4)
  /// and size (N, 3) agree.
  void require_valid(const char* where) const;
};

}  // namespace arbox::heads
