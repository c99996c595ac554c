#include "arbox/training/scene_objects.h"

#include <strings.h>

#include <algorithm>
#include <utility>

#include "arbox/base/error.h"
#include "arbox/evaluation/kitti_protocol.h"
#include "arbox/training/points_in_boxes.h"

namespace arbox::training {
namespace {

bool same_name(std::string_view first, std::string_view second) {
  return first.size() == second.size() &&
         strncasecmp(first.data(), second.data(), first.size()) == 0;
}

int find(const std::vector<std::string>& names, std::string_view name) {
  const auto found = std::find_if(names.begin(), names.end(),
                                  [&](const std::string& one) { return same_name(one, name); });
  return found == names.end() ? -1 : static_cast<int>(found - names.begin());
}

}  // namespace

ClassNames::ClassNames(std::vector<std::string> names) : names_(std::move(names)) {
  if (names_.empty()) throw ConfigError("classes: expected at least one name, got none");
  for (std::size_t i = 0; i < names_.size(); ++i) {
    if (find(names_, names_[i]) != static_cast<int>(i)) {
      throw ConfigError("classes: expected each name once, got '" + names_[i] + "' twice");
    }
    const auto settings = evaluation::kitti_class(names_[i]);
    neighbours_.push_back(settings ? settings->neighbours : std::vector<std::string>{});
  }
}

SceneObject ClassNames::object(std::string_view name) const {
  SceneObject result;
  result.label = find(names_, name);
  if (result.label >= 0) return result;
  result.label = kOtherObject;
  for (std::size_t i = 0; i < neighbours_.size(); ++i) {
    if (find(neighbours_[i], name) >= 0) result.resembles = static_cast<int>(i);
  }
  return result;
}

int difficulty_of_points(std::int64_t points) {
  if (points >= 200) return 0;
  if (points >= 50) return 1;
  return points >= 10 ? 2 : -1;
}

void finish_objects(Scene& scene, std::vector<bool> unseen, int min_points) {
  const bool any_unseen = std::find(unseen.begin(), unseen.end(), true) != unseen.end();
  if (!any_unseen && min_points <= 0) return;
  const auto points = count_points(scene.cloud, scene.objects);
  std::vector<SceneObject> kept;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (points[i] < min_points) continue;
    SceneObject& object = kept.emplace_back(scene.objects[i]);
    if (unseen[i]) object.difficulty = difficulty_of_points(points[i]);
  }
  scene.objects = std::move(kept);
}

}  // namespace arbox::training
