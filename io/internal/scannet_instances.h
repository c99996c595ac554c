#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "arbox/io/labeled_scene.h"

/// \file
/// Labels of points as ScanNet's prepared files hold them: an instance, counted from 1 (0 for
/// none), and an NYU40 id.

namespace arbox::io::internal {

/// For each point of the scene the index of its object, -1 for none. An instance is the object of
/// its class whose box holds its points most closely.
std::vector<std::int32_t> objects_of_instances(const LabeledScene& scene,
                                               std::span<const std::int32_t> instances,
                                               std::span<const std::int32_t> nyu40);

/// For each point the index of its object: point_objects where the scene has them, else the last
/// object whose box holds the point, -1 for none.
std::vector<std::int32_t> objects_of_points(const LabeledScene& scene);

struct ScanNetPointLabels {
  std::vector<std::int64_t> instances, nyu40;
};

/// The labels that stand for objects_of_points; 0 for objects whose class NYU40 does not know.
ScanNetPointLabels scannet_point_labels(const LabeledScene& scene);

}  // namespace arbox::io::internal
