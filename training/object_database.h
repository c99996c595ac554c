#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "arbox/base/option_field.h"
#include "arbox/base/random.h"
#include "arbox/training/scene.h"

/// \file
/// Ground-truth sampling (Yan et al., SECOND, Sensors 2018): objects cut out of other scans are
/// pasted into a scan, so that each one holds more to learn from.

namespace arbox::training {

/// An object with its points, where it was in its scan.
struct StoredObject {
  SceneObject object;
  /// Rows of four float32: x, y, z, intensity.
  std::vector<float> points;
  /// Its underside over the ground of its scan, metres; 0 if the ground was not known.
  double clearance = 0.0;
  bool ground_known = false;
};

struct ObjectDatabaseOptions {
  /// Objects with fewer points are not kept.
  int min_points = 5;
  /// Keep objects that are harder than hard, too.
  bool keep_hardest = false;
  /// Objects kept of each class, those of the first scenes; 0 keeps all.
  int most = 0;

  template <class Visitor>
  static void describe(Visitor& visitor) {
    using Self = ObjectDatabaseOptions;
    visitor.field("min_points", &Self::min_points,
                  {.help = "Fewest points of an object that is kept", .unit = "points", .low = 1});
    visitor.field("keep_hardest", &Self::keep_hardest,
                  {.help = "Keep objects that are harder than hard, too"});
    visitor.field("most", &Self::most,
                  {.help = "Objects kept of each class; 0 for all", .unit = "objects", .low = 0});
  }
};

/// Objects by class. Immutable; may be used from several threads.
class ObjectDatabase {
 public:
  explicit ObjectDatabase(std::vector<StoredObject> objects);

  /// Cuts the objects out of every scene of a source, on `threads` threads (0: default_threads()).
  /// The result does not depend on them. Other objects (kOtherObject) are left out. Memory: 16
  /// bytes a point. Throws ConfigError for options out of range, and as the source does.
  static ObjectDatabase build(const SceneSource& source, const ObjectDatabaseOptions& options = {},
                              int threads = 0);

  const std::vector<StoredObject>& objects() const { return objects_; }
  /// Rows of objects() of a class; none for a class that was never seen.
  std::span<const std::size_t> of(int label) const;

 private:
  std::vector<StoredObject> objects_;
  std::vector<std::vector<std::size_t>> by_label_;
};

struct ObjectSamplingOptions {
  /// Objects of each class that are tried in a scene.
  std::vector<int> counts = {15, 10, 10};
  /// Turns each object about the sensor by an angle drawn up to this, either way: pi spreads the
  /// objects all around. 0 pastes them where they were.
  double turn = 0.0;

  template <class Visitor>
  static void describe(Visitor& visitor) {
    using Self = ObjectSamplingOptions;
    visitor.field(
        "counts", &Self::counts,
        {.help = "Objects of each class that are tried in a scene; none: nothing is pasted",
         .unit = "objects",
         .low = 0,
         .high = 1000});
    visitor.field("turn", &Self::turn,
                  {.help = "Objects are turned about the sensor by up to this, either way",
                   .unit = "rad",
                   .low = 0,
                   .high = 3.15});
  }
};

/// Pastes objects into a scene. For each class, `counts` objects are drawn, in the order of the
/// classes; one that overlaps, from above, a box of the scene or one pasted before is dropped.
/// Objects are moved up or down to the scene's ground where both grounds are known. Points of the
/// scene that lie in a pasted box go; the pasted points come first in the cloud. Draws depend on
/// `random` alone. Cost: a pass over the points. The scene's cloud must have four columns,
/// InvalidArgument otherwise.
///
/// The reference implementation drops both of two drawn objects that overlap; here the first stays.
void paste_objects(Scene& scene, const ObjectDatabase& database,
                   const ObjectSamplingOptions& options, const RandomStream& random);

}  // namespace arbox::training
