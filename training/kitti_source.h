#pragma once

#include <string>
#include <vector>

#include "arbox/base/option_field.h"
#include "arbox/io/kitti_dataset.h"
#include "arbox/training/scene_objects.h"

namespace arbox::training {

struct KittiSourceOptions {
  /// A folder in the layout of io/kitti_dataset.h.
  std::string root;
  std::string split = "train";
  /// Use the labels of objects that the camera does not see, ROOT/training/label_360, which
  /// `arbox simulate street` writes, and points all around. Otherwise only points that the left
  /// colour camera sees are kept, as PV-RCNN does on KITTI, whose labels end at the image.
  bool all_round = false;
  /// Objects with fewer points are left out. Around the camera's view objects may be hidden
  /// entirely.
  int min_points = 1;
  /// Scenes at most, the first of the split; 0 for all.
  int most = 0;

  template <class Visitor>
  static void describe(Visitor& visitor) {
    using Self = KittiSourceOptions;
    visitor.field("root", &Self::root, {.help = "Folder in the layout of the KITTI benchmark"});
    visitor.field("split", &Self::split, {.help = "Which frames: a file of ImageSets"});
    visitor.field(
        "all_round", &Self::all_round,
        {.help = "Learn from points and labels all around, not in the camera's view only"});
    visitor.field("min_points", &Self::min_points,
                  {.help = "Objects with fewer points are left out", .unit = "points", .low = 0});
    visitor.field("most", &Self::most,
                  {.help = "Scenes at most; 0 for all", .unit = "scenes", .low = 0});
  }
};

/// Scenes of a folder in KITTI's layout, read anew each time.
class KittiSceneSource : public SceneSource {
 public:
  /// Throws IoError for folders that do not exist, InvalidArgument for an unknown split,
  /// FormatError for a split without frames or of the testing folder (it has no labels),
  /// ConfigError for options out of range; all-round labels that are missing are told by scene(),
  /// as IoError.
  KittiSceneSource(KittiSourceOptions options, ClassNames classes);

  std::int64_t size() const override { return static_cast<std::int64_t>(frames_.size()); }
  Scene scene(std::int64_t index) const override;

 private:
  KittiSourceOptions options_;
  ClassNames classes_;
  io::KittiDataset dataset_;
  std::vector<std::string> frames_;
};

}  // namespace arbox::training
