#pragma once

#include <memory>
#include <string>
#include <vector>

#include "arbox/training/kitti_source.h"
#include "arbox/training/street_source.h"

namespace arbox::training {

/// Where scenes come from, as a configuration says it.
struct SceneDataOptions {
  /// `kitti`: a folder; `street`: the simulator; `none`.
  std::string kind = "kitti";
  KittiSourceOptions kitti;
  StreetSourceOptions street;

  template <class Visitor>
  static void describe(Visitor& visitor) {
    using Self = SceneDataOptions;
    visitor.field("kind", &Self::kind,
                  {.help = "A folder in KITTI's layout, the simulator, or none",
                   .choices = {"kitti", "street", "none"}});
    visitor.group("kitti", &Self::kitti, "Scenes of a folder");
    visitor.group("street", &Self::street, "Scenes of the simulator");
  }
};

/// Nothing if the kind is none. Throws ConfigError for options out of range, and as the source that
/// is asked for.
std::unique_ptr<SceneSource> make_scene_source(const SceneDataOptions& options,
                                               const std::vector<std::string>& classes);

}  // namespace arbox::training
