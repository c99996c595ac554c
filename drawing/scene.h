#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "arbox/drawing/image.h"
#include "arbox/geometry/detection.h"
#include "arbox/geometry/point_cloud_view.h"

/// \file
/// The picture of a scan and of what was found in it: what `arbox view` and `arbox detect --view`
/// write.

namespace arbox::drawing {

/// A photo taken together with the scan.
struct Photo {
  Image image;
  /// Pixel of a point p of the cloud's frame: (u, v) = (a, b) / w with (a, b, w) = projection *
  /// (p, 1); w is the distance in front of the camera, metres. (0, 0) is the centre of the top left
  /// pixel.
  Eigen::Matrix<double, 3, 4> projection = Eigen::Matrix<double, 3, 4>::Zero();
};

/// What is drawn; everything in one frame with z up, metres. Each part may be empty.
struct Scene {
  /// Points with non-finite coordinates are left out.
  geometry::PointCloudView cloud;
  /// Solid boxes with scores; their quantile boxes, confidence boxes and samples are drawn too.
  std::vector<geometry::Detection> predictions;
  /// Dashed boxes; of these only the label and the box are used.
  std::vector<geometry::Detection> truth;
  /// For each of `truth` whether its box's x axis is the object's front, which is drawn then; empty
  /// stands for all.
  std::vector<bool> truth_has_front = {};
  std::optional<Photo> photo;
};

enum class SceneView { kBirdseye, kPerspective, kBoth };
enum class PointColor { kHeight, kIntensity, kRgb };
enum class Background { kLight, kDark };

struct SceneOptions {
  SceneView view = SceneView::kBoth;
  PointColor color = PointColor::kHeight;
  Background background = Background::kLight;
  /// Text above the picture; none if empty.
  std::string title = {};
  int width = 1800;
  int height = 0;
  double range = 0.0;
  double azimuth = -160.0;
  std::optional<double> elevation = {};
  double minimum_score = 0.0;
  bool captions = true;

  template <class Visitor>
  static void describe(Visitor& visitor) {
    visitor.field("view", &SceneOptions::view,
                  {.help = "Which views of the cloud are drawn",
                   .choices = {"birdseye", "perspective", "both"}});
    visitor.field(
        "color", &SceneOptions::color,
        {.help = "What the colour of a point shows", .choices = {"height", "intensity", "rgb"}});
    visitor.field("background", &SceneOptions::background,
                  {.help = "Brightness of the picture's background", .choices = {"light", "dark"}});
    visitor.field("title", &SceneOptions::title, {.help = "Text above the picture"});
    visitor.field("width", &SceneOptions::width,
                  {.help = "Width of the picture", .unit = "pixels", .low = 320, .high = 8192});
    visitor.field("height", &SceneOptions::height,
                  {.help = "Height of the picture; 0 follows from the width and the content",
                   .unit = "pixels",
                   .low = 0,
                   .high = 8192});
    visitor.field("range", &SceneOptions::range,
                  {.help = "Distance from the origin that is shown; 0 follows from the data",
                   .unit = "m",
                   .low = 0,
                   .high = 10000});
    visitor.field("azimuth", &SceneOptions::azimuth,
                  {.help = "Where the camera of the perspective view stands, seen from the scene, "
                           "counter-clockwise from +x",
                   .unit = "degrees",
                   .low = -360,
                   .high = 360});
    visitor.field(
        "elevation", &SceneOptions::elevation,
        {.help = "Height of that camera above the horizon; follows from the data if not given",
         .unit = "degrees",
         .low = 1,
         .high = 89});
    visitor.field("minimum_score", &SceneOptions::minimum_score,
                  {.help = "Predictions with lower scores are left out", .low = 0, .high = 1});
    visitor.field("captions", &SceneOptions::captions,
                  {.help = "Write class and score beside the boxes"});
  }
};

/// Draws bird's-eye view, perspective view and photo with boxes, as far as asked for and there,
/// with legend, scale bar, and range rings or a grid. Boxes have their class's colour
/// (class_color).
///
/// Extent and camera follow from the points and the boxes unless options say otherwise. Equal input
/// gives equal pixels. About linear in points; 120000 points take a fraction of a second.
///
/// Throws ConfigError for options out of range; InvalidArgument for a height that is too small for
/// the content, for colour by a channel that a non-empty cloud does not have, for invalid boxes,
/// for a truth_has_front that is neither empty nor as long as truth, and for a photo whose
/// projection is not finite.
Image draw_scene(const Scene& scene, const SceneOptions& options = {});

}  // namespace arbox::drawing
