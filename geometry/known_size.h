#pragma once

#include <Eigen/Core>
#include <map>
#include <string>
#include <vector>

namespace arbox::geometry {

/// A size that an object may have: a model of car, a stock-keeping unit.
struct KnownSize {
  std::string name;                                ///< For people; may be empty.
  Eigen::Vector3d size = Eigen::Vector3d::Ones();  ///< Length, width, height; metres, above zero.
};

/// The sizes that the objects of a class may have, by class.
using KnownSizes = std::map<std::string, std::vector<KnownSize>>;

}  // namespace arbox::geometry
