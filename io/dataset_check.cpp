#include "arbox/io/dataset_check.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "arbox/base/error.h"
#include "arbox/base/parallel.h"
#include "arbox/geometry/overlap.h"
#include "arbox/io/internal/label_mistakes.h"

namespace arbox::io {
namespace {

using internal::Evidence;

constexpr std::size_t kExamples = 5;
// Mistakes are the same in all scans: some scans tell them.
constexpr std::size_t kWeighed = 400;
constexpr int kThreadsPerCore = 4;
constexpr double kLargestSize = 60.0;
constexpr double kSmallestSize = 0.005;
constexpr double kSameBox = 0.9;
constexpr double kFullTurn = 2 * std::numbers::pi + 1e-3;

enum Kind { kBroken, kEmpty, kNoPoints, kSize, kDoubled, kAngle, kKinds };

/// What one scene shows.
struct SceneFindings {
  bool readable = false, labelled = false;
  std::size_t objects = 0;
  std::uint64_t points = 0;
  std::map<std::string, ClassSummary> classes;
  std::vector<std::string> places[kKinds];
  std::vector<Evidence> evidence;
};

std::string place_of(const LabeledScene& scene, std::size_t object) {
  return scene.name + " object " + std::to_string(object) + " (" + scene.objects[object].label +
         ")";
}

void check_object(const LabeledScene& scene, std::size_t i, const internal::PointGrid& grid,
                  bool weighed, SceneFindings& found) {
  const LabeledObject& object = scene.objects[i];
  ClassSummary& summary = found.classes[object.label];
  ++summary.objects;
  summary.mean_size += object.box.size;
  if (internal::points_inside(grid, object.box, 1) == 0) {
    ++summary.without_points;
    found.places[kNoPoints].push_back(place_of(scene, i));
  }
  if (object.box.size.maxCoeff() > kLargestSize || object.box.size.minCoeff() < kSmallestSize) {
    // Flat boxes around walls and pictures are no mistake where boxes are hulls.
    if (object.heading != Heading::kUnknown || object.box.size.maxCoeff() > kLargestSize) {
      found.places[kSize].push_back(place_of(scene, i));
    }
  }
  if (object.written_yaw && std::abs(*object.written_yaw) > kFullTurn) {
    found.places[kAngle].push_back(place_of(scene, i));
  }
  for (std::size_t other = 0; other < i; ++other) {
    if (scene.objects[other].label != object.label) continue;
    if (geometry::overlap(scene.objects[other].box, object.box) > kSameBox) {
      found.places[kDoubled].push_back(place_of(scene, i));
      break;
    }
  }
  if (!weighed) return;
  const auto evidence = internal::weigh(grid, object);
  for (std::size_t m = 0; m < evidence.size(); ++m) found.evidence[m].add(evidence[m]);
}

/// What is weighed may lie anywhere; whether a box holds points is seen close to it.
internal::PointGrid points_to_check(const LabeledScene& scene, bool weighed) {
  if (weighed) return internal::PointGrid(scene.cloud.view());
  std::vector<internal::Square> squares;
  for (const LabeledObject& object : scene.objects) {
    const internal::Square square = internal::around(object.box);
    if (std::isfinite(square.x + square.y + square.reach)) squares.push_back(square);
  }
  return {scene.cloud.view(), squares};
}

SceneFindings check_scene(const DatasetReader& dataset, std::string_view split,
                          const std::string& name, bool weighed) {
  SceneFindings found;
  found.evidence.resize(internal::known_mistakes().size());
  try {
    const LabeledScene scene = dataset.load(split, name);
    found.readable = true;
    found.labelled = scene.labelled;
    found.objects = scene.objects.size();
    found.points = scene.cloud.size();
    // What is known of mistakes stands on ground that lies below, not at the camera's z.
    const bool upright = scene.frame != SceneFrame::kCamera;
    const internal::PointGrid grid = points_to_check(scene, weighed && upright);
    if (!internal::has_finite_point(scene.cloud.view())) found.places[kEmpty].push_back(name);
    for (std::size_t i = 0; i < scene.objects.size(); ++i) {
      geometry::require_valid(scene.objects[i].box, place_of(scene, i));
      check_object(scene, i, grid, weighed && upright, found);
    }
  } catch (const Error& error) {
    found.places[kBroken].push_back(error.what());
  }
  return found;
}

void merge(const SceneFindings& found, DatasetCheck& check, SceneFindings& all) {
  ++check.scenes;
  check.labelled += found.labelled ? 1 : 0;
  check.objects += found.objects;
  check.points += found.points;
  for (const auto& [name, summary] : found.classes) {
    ClassSummary& total = check.classes[name];
    total.objects += summary.objects;
    total.without_points += summary.without_points;
    total.mean_size += summary.mean_size;
  }
  for (int kind = 0; kind < kKinds; ++kind) {
    all.places[kind].insert(all.places[kind].end(), found.places[kind].begin(),
                            found.places[kind].end());
  }
  for (std::size_t m = 0; m < all.evidence.size(); ++m) all.evidence[m].add(found.evidence[m]);
}

void report(DatasetCheck& check, std::string kind, std::string text, std::string mend,
            const std::vector<std::string>& places) {
  if (places.empty()) return;
  DatasetFinding finding{.kind = std::move(kind),
                         .text = std::to_string(places.size()) + " " + std::move(text),
                         .mend = std::move(mend),
                         .count = places.size(),
                         .examples = {}};
  for (std::size_t i = 0; i < std::min(places.size(), kExamples); ++i) {
    finding.examples.push_back(places[i]);
  }
  check.findings.push_back(std::move(finding));
}

void report_mistake(DatasetCheck& check, const SceneFindings& all) {
  const auto mistake = internal::likely_mistake(all.evidence);
  if (!mistake) return;
  const internal::Mistake& one = internal::known_mistakes()[*mistake];
  const Evidence& evidence = all.evidence[*mistake];
  check.findings.push_back({.kind = one.kind,
                            .text = one.text + ": " + std::to_string(evidence.better) + " of " +
                                    std::to_string(evidence.boxes) +
                                    " boxes fit their points better without that, " +
                                    std::to_string(evidence.worse) + " worse",
                            .mend = one.mend,
                            .count = evidence.better,
                            .examples = {}});
}

}  // namespace

DatasetCheck check_dataset(const DatasetReader& dataset, std::string_view split, int threads,
                           const std::function<void()>& done) {
  const std::vector<std::string> names = dataset.names(split);
  const std::size_t step = std::max<std::size_t>(1, names.size() / kWeighed);
  std::vector<SceneFindings> found(names.size());
  // Most wait for the disk while others look at their points.
  const int workers = threads == 0 ? kThreadsPerCore * default_threads() : threads;
  parallel_for(static_cast<std::int64_t>(names.size()), 1, workers,
               [&](std::int64_t begin, std::int64_t end) {
                 for (std::int64_t i = begin; i < end; ++i) {
                   const auto at = static_cast<std::size_t>(i);
                   found[at] = check_scene(dataset, split, names[at], at % step == 0);
                   if (done) done();
                 }
               });
  DatasetCheck check;
  check.layout = dataset.layout();
  check.split = split;
  SceneFindings all;
  all.evidence.resize(internal::known_mistakes().size());
  for (const SceneFindings& one : found) merge(one, check, all);
  for (auto& [name, summary] : check.classes) {
    summary.mean_size /= static_cast<double>(summary.objects);
  }
  report(check, "broken", "scans cannot be read", "", all.places[kBroken]);
  report(check, "folder", "things are wrong with the folder", "", dataset.problems());
  report_mistake(check, all);
  report(check, "degrees", "boxes have a yaw beyond a full turn",
         "write radians, in (-pi, pi]; if they are degrees, multiply by pi/180",
         all.places[kAngle]);
  report(check, "empty scan", "scans hold no points",
         "leave them out of the splits, or look at how they were recorded", all.places[kEmpty]);
  report(check, "box without points", "boxes hold no points",
         "remove them, or tell them apart: a detector cannot learn what was not seen",
         all.places[kNoPoints]);
  report(check, "large box", "boxes have a size above 60 m or below 5 mm",
         "sizes are in metres, full extents", all.places[kSize]);
  report(check, "doubled box", "boxes stand where another one of their class stands",
         "remove one of the two", all.places[kDoubled]);
  return check;
}

}  // namespace arbox::io
