#include "arbox/training/object_database.h"

#include <algorithm>
#include <array>
#include <utility>

#include "arbox/base/error.h"
#include "arbox/base/options.h"
#include "arbox/base/parallel.h"
#include "arbox/geometry/overlap.h"
#include "arbox/training/points_in_boxes.h"
#include "arbox/training/scene_transform.h"

namespace arbox::training {
namespace {

using geometry::Box;

constexpr std::size_t kColumns = 4;

void require_columns(const Scene& scene, const char* where) {
  if (scene.cloud.columns() == kColumns) return;
  throw InvalidArgument(std::string(where) + ": " + scene.source +
                        ": expected points x y z intensity, got " +
                        std::to_string(scene.cloud.columns()) + " columns");
}

double underside(const Box& box) { return box.center.z() - 0.5 * box.size.z(); }

std::vector<StoredObject> cut_objects(const Scene& scene, const ObjectDatabaseOptions& options) {
  require_columns(scene, "object database");
  std::vector<SceneObject> wanted;
  std::vector<Box> boxes;
  for (const SceneObject& object : scene.objects) {
    if (object.label < 0 || (object.difficulty < 0 && !options.keep_hardest)) continue;
    wanted.push_back(object);
    boxes.push_back(object.box);
  }
  const auto points = points_inside(scene.cloud, boxes);
  std::vector<StoredObject> result;
  for (std::size_t k = 0; k < wanted.size(); ++k) {
    const SceneObject& object = wanted[k];
    const std::vector<std::size_t>& inside = points[k];
    if (inside.size() < static_cast<std::size_t>(options.min_points)) continue;
    StoredObject& stored = result.emplace_back();
    stored.object = object;
    stored.points.reserve(inside.size() * kColumns);
    for (const std::size_t i : inside) {
      const auto point = scene.cloud.values.begin() + static_cast<std::ptrdiff_t>(i * kColumns);
      stored.points.insert(stored.points.end(), point, point + kColumns);
    }
    stored.ground_known = scene.ground.has_value();
    if (scene.ground) {
      const Eigen::Vector3d& center = object.box.center;
      stored.clearance =
          underside(object.box) - ground_height(*scene.ground, center.x(), center.y());
    }
  }
  return result;
}

/// Moves the object and its points: a turn about the sensor, then up or down.
void place(StoredObject& stored, double angle, const std::optional<io::KittiPlane>& ground) {
  Scene moved;
  moved.cloud = {.channels = {"intensity"}, .values = std::move(stored.points)};
  moved.objects = {stored.object};
  if (angle != 0) rotate(moved, angle);
  Box& box = moved.objects[0].box;
  if (ground && stored.ground_known) {
    const double rise =
        ground_height(*ground, box.center.x(), box.center.y()) + stored.clearance - underside(box);
    box.center.z() += rise;
    for (std::size_t i = 2; i < moved.cloud.values.size(); i += kColumns) {
      moved.cloud.values[i] = static_cast<float>(moved.cloud.values[i] + rise);
    }
  }
  stored.object = moved.objects[0];
  stored.points = std::move(moved.cloud.values);
}

bool is_free(const Box& box, std::span<const Box> present) {
  const auto shared = geometry::overlap_matrix(std::span(&box, 1), present,
                                               {.measure = geometry::Overlap::kIntersection,
                                                .space = geometry::OverlapSpace::kBirdsEye,
                                                .threads = 1});
  return shared.size() == 0 || shared.maxCoeff() <= 0.0;
}

void join(Scene& scene, std::span<const StoredObject> pasted, std::span<const Box> boxes) {
  remove_points_inside(scene.cloud, boxes);
  std::vector<float> values;
  for (const StoredObject& stored : pasted) {
    values.insert(values.end(), stored.points.begin(), stored.points.end());
    scene.objects.push_back(stored.object);
  }
  scene.cloud.values.insert(scene.cloud.values.begin(), values.begin(), values.end());
}

}  // namespace

ObjectDatabase::ObjectDatabase(std::vector<StoredObject> objects) : objects_(std::move(objects)) {
  for (std::size_t i = 0; i < objects_.size(); ++i) {
    const int label = objects_[i].object.label;
    if (label < 0) throw InvalidArgument("object database: expected objects of a class");
    if (by_label_.size() <= static_cast<std::size_t>(label)) by_label_.resize(label + 1);
    by_label_[label].push_back(i);
  }
}

ObjectDatabase ObjectDatabase::build(const SceneSource& source,
                                     const ObjectDatabaseOptions& options, int threads) {
  validate_options(options, "object database");
  std::vector<std::vector<StoredObject>> cut(static_cast<std::size_t>(source.size()));
  parallel_for(source.size(), 1, threads, [&](std::int64_t first, std::int64_t last) {
    for (std::int64_t i = first; i < last; ++i) cut[i] = cut_objects(source.scene(i), options);
  });
  std::vector<StoredObject> objects;
  std::vector<int> kept;
  for (std::vector<StoredObject>& scene : cut) {
    for (StoredObject& stored : scene) {
      const auto label = static_cast<std::size_t>(stored.object.label);
      if (kept.size() <= label) kept.resize(label + 1);
      if (options.most > 0 && kept[label] >= options.most) continue;
      ++kept[label];
      objects.push_back(std::move(stored));
    }
  }
  return ObjectDatabase(std::move(objects));
}

std::span<const std::size_t> ObjectDatabase::of(int label) const {
  if (label < 0 || static_cast<std::size_t>(label) >= by_label_.size()) return {};
  return by_label_[label];
}

void paste_objects(Scene& scene, const ObjectDatabase& database,
                   const ObjectSamplingOptions& options, const RandomStream& random) {
  require_columns(scene, "paste_objects");
  std::vector<Box> present;
  for (const SceneObject& object : scene.objects) present.push_back(object.box);
  const std::size_t before = present.size();
  std::vector<StoredObject> pasted;
  std::uint32_t draw = 0;
  for (std::size_t label = 0; label < options.counts.size(); ++label) {
    const auto pool = database.of(static_cast<int>(label));
    for (int i = 0; i < options.counts[label]; ++i, draw += 2) {
      if (pool.empty()) continue;
      StoredObject stored =
          database.objects()[pool[random.below(draw, static_cast<std::uint32_t>(pool.size()))]];
      place(stored, options.turn * random.uniform(draw + 1, -1.0, 1.0), scene.ground);
      if (!is_free(stored.object.box, present)) continue;
      present.push_back(stored.object.box);
      pasted.push_back(std::move(stored));
    }
  }
  join(scene, pasted, std::span(present).subspan(before));
}

}  // namespace arbox::training
