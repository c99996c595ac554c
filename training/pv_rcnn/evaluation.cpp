#include "arbox/training/pv_rcnn/evaluation.h"

#include <algorithm>
#include <array>
#include <utility>

#include "arbox/detectors/pv_rcnn/pv_rcnn.h"
#include "arbox/geometry/overlap.h"
#include "arbox/io/kitti.h"

namespace arbox::training::pv_rcnn {

using detectors::pv_rcnn::Network;
using detectors::pv_rcnn::Options;
using geometry::Box;
using geometry::Detection;

namespace {

/// Label fields that the protocol takes for each difficulty; the last is harder than hard.
struct Seen {
  double height;
  int occlusion;
  double truncation;
};
constexpr std::array<Seen, 4> kSeen = {{{100, 0, 0}, {30, 1, 0.2}, {30, 2, 0.4}, {10, 3, 0.9}}};

const Seen& seen(int difficulty) { return kSeen[difficulty < 0 ? 3 : std::min(difficulty, 2)]; }

std::string neighbour(const std::string& name) { return "other " + name; }

bool in_range(const Box& box, const detectors::pv_rcnn::VoxelOptions& range) {
  for (int axis = 0; axis < 3; ++axis) {
    if (box.center[axis] < range.low[axis] || box.center[axis] > range.high[axis]) return false;
  }
  return true;
}

Detection detection(std::string label, double score, const Box& box) {
  Detection result;
  result.label = std::move(label);
  result.score = score;
  result.box = box;
  return result;
}

io::KittiObject to_object(const Box& box, const std::string& type) {
  io::KittiObject object = io::to_kitti_results(std::vector{detection(type, 0.0, box)})[0];
  object.alpha = io::observation_angle(object);
  object.left = object.top = 0;
  object.right = object.bottom = kSeen[0].height;
  return object;
}

/// Sums of the IoU of objects with their best detection, by class.
struct Found {
  std::vector<double> iou;
  std::vector<std::int64_t> objects;

  explicit Found(std::size_t classes) : iou(classes, 0.0), objects(classes, 0) {}

  void add(const Scene& scene, const std::vector<Detection>& detections, const Options& options) {
    for (const SceneObject& object : scene.objects) {
      if (object.label < 0 || object.difficulty < 0 || !in_range(object.box, options.voxels)) {
        continue;
      }
      double best = 0.0;
      for (const Detection& one : detections) {
        if (one.label != options.classes[object.label]) continue;
        best = std::max(best, geometry::overlap(one.box, object.box));
      }
      iou[object.label] += best;
      ++objects[object.label];
    }
  }
};

void add_figures(const evaluation::KittiReport& report, const Found& found,
                 std::map<std::string, double>& figures) {
  for (std::size_t c = 0; c < report.classes.size(); ++c) {
    const evaluation::KittiClassResult& result = report.classes[c];
    const std::string& name = result.settings.name;
    const auto add = [&](const std::string& metric,
                         const std::optional<evaluation::KittiCurves>& curves) {
      for (std::size_t d = 0; d < evaluation::kKittiDifficulties.size(); ++d) {
        figures[name + " " + metric + " R40 " + std::string(evaluation::kKittiDifficulties[d])] =
            curves ? (*curves)[d].r40() : 0.0;
      }
    };
    add("3d", result.box3d);
    add("bev", result.birds_eye);
    figures[name + " found"] =
        found.iou[c] / static_cast<double>(std::max<std::int64_t>(found.objects[c], 1));
  }
}

}  // namespace

evaluation::KittiFrame to_kitti_frame(const Scene& scene, std::span<const Detection> detections,
                                      const Options& options) {
  evaluation::KittiFrame frame;
  for (const SceneObject& object : scene.objects) {
    const int label = object.label >= 0 ? object.label : object.resembles;
    if (label < 0 || !in_range(object.box, options.voxels)) continue;
    const std::string& name = options.classes[label];
    io::KittiObject& added = frame.labels.emplace_back(
        to_object(object.box, object.label >= 0 ? name : neighbour(name)));
    const Seen& how = seen(object.difficulty);
    added.bottom = how.height;
    added.occlusion = how.occlusion;
    added.truncation = how.truncation;
  }
  for (const Detection& one : detections) {
    if (!in_range(one.box, options.voxels)) continue;
    frame.predictions.emplace_back(to_object(one.box, one.label)).score = one.score;
  }
  return frame;
}

std::vector<evaluation::KittiClass> kitti_classes(const std::vector<std::string>& classes) {
  std::vector<evaluation::KittiClass> result;
  for (const std::string& name : classes) {
    evaluation::KittiClass settings =
        evaluation::kitti_class(name).value_or(evaluation::KittiClass());
    settings.name = name;
    settings.neighbours = {neighbour(name)};
    result.push_back(std::move(settings));
  }
  return result;
}

std::map<std::string, std::map<std::string, double>> evaluate_heads(
    const std::shared_ptr<Network>& network, const SceneSource& scenes) {
  const Options& options = network->options();
  const auto& heads = network->heads();
  const detectors::pv_rcnn::PvRcnn detector(network);
  std::vector<std::vector<evaluation::KittiFrame>> frames(heads.size());
  std::vector<Found> found(heads.size(), Found(options.classes.size()));
  for (std::int64_t i = 0; i < scenes.size(); ++i) {
    const Scene scene = scenes.scene(i);
    const auto results =
        detector.detect_with_every_head(scene.cloud.view(), {.uncertainty = false});
    for (std::size_t h = 0; h < heads.size(); ++h) {
      frames[h].push_back(to_kitti_frame(scene, results[h].detections, options));
      found[h].add(scene, results[h].detections, options);
    }
  }
  std::map<std::string, std::map<std::string, double>> result;
  for (std::size_t h = 0; h < heads.size(); ++h) {
    const auto report =
        evaluation::evaluate_kitti(frames[h], {.classes = kitti_classes(options.classes)});
    add_figures(report, found[h], result[heads[h].first]);
  }
  return result;
}

}  // namespace arbox::training::pv_rcnn
