#pragma once

#include <cstdint>
#include <memory>
#include <numbers>

#include "arbox/training/object_database.h"

namespace arbox::training {

/// How scenes are changed before a network sees them, in this order: objects pasted, mirrored,
/// turned, scaled. Defaults are those of PV-RCNN on KITTI's forward view.
struct AugmentationOptions {
  /// Change nothing at all if false.
  bool enabled = true;
  ObjectDatabaseOptions database;
  ObjectSamplingOptions objects;
  /// Shares of the scenes whose left and right, front and back are exchanged.
  double flip_left_right = 0.5, flip_front_back = 0.0;
  /// Scenes are turned about the sensor by up to this, either way.
  double rotation = 0.25 * std::numbers::pi;
  double scale_low = 0.95, scale_high = 1.05;

  /// For networks that look all around: any direction is as good as another.
  static AugmentationOptions all_round() {
    AugmentationOptions options;
    options.objects.turn = std::numbers::pi;
    options.flip_front_back = 0.5;
    options.rotation = std::numbers::pi;
    return options;
  }

  template <class Visitor>
  static void describe(Visitor& visitor) {
    using Self = AugmentationOptions;
    visitor.field("enabled", &Self::enabled, {.help = "Change scenes at all"});
    visitor.group("database", &Self::database, "Which objects are kept for pasting");
    visitor.group("objects", &Self::objects, "Objects that are pasted into scenes");
    visitor.field(
        "flip_left_right", &Self::flip_left_right,
        {.help = "Share of the scenes that are mirrored left to right", .low = 0, .high = 1});
    visitor.field(
        "flip_front_back", &Self::flip_front_back,
        {.help = "Share of the scenes that are mirrored front to back", .low = 0, .high = 1});
    visitor.field("rotation", &Self::rotation,
                  {.help = "Scenes are turned by up to this, either way",
                   .unit = "rad",
                   .low = 0,
                   .high = 3.15});
    visitor.field("scale_low", &Self::scale_low,
                  {.help = "Smallest factor of places and sizes", .low = 0.1, .high = 10});
    visitor.field("scale_high", &Self::scale_high,
                  {.help = "Largest factor of places and sizes", .low = 0.1, .high = 10});
  }
};

/// Changes the scene at `place` of the run with this seed; the change depends on scene, options,
/// database, seed and place alone. Without a database nothing is pasted. Throws ConfigError for
/// options out of range or scale_low above scale_high.
void augment(Scene& scene, const AugmentationOptions& options, const ObjectDatabase* database,
             std::uint64_t seed, std::int64_t place);

}  // namespace arbox::training
