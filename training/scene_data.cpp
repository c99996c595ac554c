#include "arbox/training/scene_data.h"

#include <utility>

#include "arbox/base/options.h"

namespace arbox::training {

std::unique_ptr<SceneSource> make_scene_source(const SceneDataOptions& options,
                                               const std::vector<std::string>& classes) {
  validate_options(options, "scenes");
  if (options.kind == "none") return nullptr;
  ClassNames names(classes);
  if (options.kind == "street") {
    return std::make_unique<StreetSceneSource>(options.street, std::move(names));
  }
  return std::make_unique<KittiSceneSource>(options.kitti, std::move(names));
}

}  // namespace arbox::training
