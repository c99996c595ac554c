#pragma once

#include <span>
#include <vector>

#include "arbox/base/option_field.h"
#include "arbox/geometry/box.h"
#include "arbox/io/kitti_object.h"
#include "arbox/simulation/kitti_cameras.h"
#include "arbox/simulation/ray_tracer.h"
#include "arbox/simulation/scene.h"

namespace arbox::simulation {

/// What the people who label a scan would see. The defaults follow KITTI's labels: objects are
/// labelled by the image, whatever number of points they have.
struct LabelOptions {
  /// Objects of which less is visible get no label.
  double least_visible = 0.12;
  /// More visible: occlusion level 0; more than the second: 1; else 2.
  double fully_visible = 0.85, partly_visible = 0.42;
  /// Lower 2-D boxes (pixels) are never labelled; those up to `small_height` in part, and become
  /// DontCare areas otherwise.
  double least_height = 14.0, small_height = 27.0;
  /// Share of the small objects that get a label.
  double small_labelled = 0.4;
  /// Share of the truncated objects whose occlusion level is 3 (unknown).
  double truncated_unknown = 0.25;
  /// Share of the other objects in view that become DontCare areas.
  double ignored = 0.55;
  /// Farther objects (metres from the camera) get no label.
  double farthest = 85.0;
  /// Objects with a larger part outside of the image get no label.
  double most_truncated = 0.985;

  template <class Visitor>
  static void describe(Visitor& visitor) {
    const auto share = [&](std::string_view name, double LabelOptions::*member,
                           std::string_view help) {
      visitor.field(name, member, {.help = help, .low = 0.0, .high = 1.0});
    };
    share("least_visible", &LabelOptions::least_visible,
          "Visible share below which an object gets no label");
    share("fully_visible", &LabelOptions::fully_visible,
          "Visible share from which the occlusion level is 0");
    share("partly_visible", &LabelOptions::partly_visible,
          "Visible share from which the occlusion level is 1");
    visitor.field("least_height", &LabelOptions::least_height,
                  {.help = "Height in the image below which nothing is labelled",
                   .unit = "pixels",
                   .low = 0,
                   .high = 1000});
    visitor.field("small_height", &LabelOptions::small_height,
                  {.help = "Height in the image below which only a part is labelled",
                   .unit = "pixels",
                   .low = 0,
                   .high = 1000});
    share("small_labelled", &LabelOptions::small_labelled, "That part");
    share("truncated_unknown", &LabelOptions::truncated_unknown,
          "Share of the truncated objects whose occlusion level is 3 (unknown)");
    share("ignored", &LabelOptions::ignored,
          "Share of the other objects in view that become DontCare areas");
    visitor.field(
        "farthest", &LabelOptions::farthest,
        {.help = "Distance beyond which nothing is labelled", .unit = "m", .low = 0, .high = 1000});
    share("most_truncated", &LabelOptions::most_truncated,
          "Share outside of the image above which an object gets no label");
  }
};

struct SceneLabels {
  /// What a label_2 file has: objects in the left colour camera's view, nearest first as far as
  /// Scene::objects is, then DontCare areas.
  std::vector<io::KittiObject> image;
  /// All other objects: truncation 1, occlusion 3, a 2-D box of zeros.
  std::vector<io::KittiObject> around;
  /// Indices into Scene::objects of the labels in `image` (without DontCare) and in `around`.
  std::vector<std::size_t> image_objects, around_objects;
};

/// Labels of a scene in the benchmark's numbers, with these boxes for Scene::objects: scanned_boxes
/// of the scan that the labels go with. The rest is what the camera sees at the reference time: 2-D
/// boxes are the bounds of the projected triangles cut to the image; truncation the share of them
/// that is cut away; occlusion from rays of the camera: the share of the object's own outline in
/// the image that nothing covers. Throws InvalidArgument if boxes and objects differ in number.
/// Cost: some 150 rays an object in view.
SceneLabels make_labels(const Scene& scene, std::span<const geometry::Box> boxes,
                        const RayTracer& tracer, const CameraView& camera,
                        const LabelOptions& options = {});

/// The ground plane of a planes file, in the rectified camera frame.
io::KittiPlane ground_plane(const Scene& scene, const CameraView& camera);

}  // namespace arbox::simulation
