#pragma once

#include <Eigen/Core>

#include "arbox/simulation/scene.h"

namespace arbox::simulation {

/// True where a line of the road is painted.
bool is_painted(const RoadMarkings& markings, const Eigen::Vector3d& point);

/// Smooth patches of about `wavelength` metres over the ground, -1..1.
double patchiness(const Eigen::Vector3d& point, double wavelength);

}  // namespace arbox::simulation
