#pragma once

#include <Eigen/Core>
#include <string_view>

#include "arbox/simulation/internal/model_builders.h"

namespace arbox::simulation {

/// Length, width and height of an object of a KITTI class, metres: a normal distribution with the
/// means, spreads and correlations of all labels of the benchmark's training set, cut to their 1 %
/// and 99 % quantiles (docs/simulation.md).
Eigen::Vector3d draw_size(std::string_view label, Dice& dice);

}  // namespace arbox::simulation
