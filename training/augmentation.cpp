#include "arbox/training/augmentation.h"

#include "arbox/base/error.h"
#include "arbox/base/options.h"
#include "arbox/base/random.h"
#include "arbox/training/internal/purposes.h"
#include "arbox/training/scene_transform.h"

namespace arbox::training {

void augment(Scene& scene, const AugmentationOptions& options, const ObjectDatabase* database,
             std::uint64_t seed, std::int64_t place) {
  validate_options(options, "augmentation");
  if (options.scale_low > options.scale_high) {
    throw ConfigError("augmentation: expected scale_low at most scale_high, got " +
                      std::to_string(options.scale_low) + " and " +
                      std::to_string(options.scale_high));
  }
  if (!options.enabled) return;
  const auto object = static_cast<std::uint64_t>(place);
  if (database != nullptr) {
    paste_objects(scene, *database, options.objects,
                  RandomStream(seed, object, internal::kPastedObjects));
  }
  const RandomStream random(seed, object, internal::kGlobalAugmentation);
  if (random.uniform(0) < options.flip_left_right) flip_left_right(scene);
  if (random.uniform(1) < options.flip_front_back) flip_front_back(scene);
  if (options.rotation > 0) rotate(scene, options.rotation * random.uniform(2, -1.0, 1.0));
  if (options.scale_low < 1 || options.scale_high > 1) {
    scale(scene, random.uniform(3, options.scale_low, options.scale_high));
  }
}

}  // namespace arbox::training
