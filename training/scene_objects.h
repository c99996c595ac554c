#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "arbox/training/scene.h"

namespace arbox::training {

/// Which class names a network looks for, and what becomes of the others.
///
/// A name of the network's classes (without case) is an object of that class. Any other name is an
/// other object; it resembles the class whose neighbour the KITTI benchmark calls it: a Van a Car,
/// a Person_sitting a Pedestrian. What a loss makes of that is the option `ignore_similar` of the
/// targets (pv_rcnn/anchor_targets.h).
class ClassNames {
 public:
  /// Throws ConfigError for no names, and for names that are doubled.
  explicit ClassNames(std::vector<std::string> names);

  const std::vector<std::string>& names() const { return names_; }
  /// An object of that name; box and difficulty are left to the caller.
  SceneObject object(std::string_view name) const;

 private:
  std::vector<std::string> names_;
  std::vector<std::vector<std::string>> neighbours_;
};

/// How hard an object is that no camera saw, by its points: 0 from 200 on, 1 from 50, 2 from 10, -1
/// below. About what the benchmark's difficulties have in KITTI.
int difficulty_of_points(std::int64_t points);

/// Sets the difficulty of the objects that `unseen` names by their points, and leaves out objects
/// with fewer than `min_points`. One pass over the points an object.
void finish_objects(Scene& scene, std::vector<bool> unseen, int min_points);

}  // namespace arbox::training
