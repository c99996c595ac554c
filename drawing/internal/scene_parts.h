#pragma once

#include <optional>
#include <string>
#include <vector>

#include "arbox/drawing/internal/canvas.h"
#include "arbox/drawing/internal/projection.h"
#include "arbox/drawing/scene.h"

/// \file
/// What the views of a scene share.

namespace arbox::drawing {

struct Theme {
  bool dark;
  Color paper, panel, ink, soft_ink, grid;
  /// One unit of length of the picture, pixels: line widths and text sizes are multiples of it.
  double unit;
  /// How strongly the front faces of boxes are tinted.
  double front_opacity = 0.22;
};

Theme make_theme(const SceneOptions& options);

/// The colour of a class on the theme's background.
Color theme_color(const Theme& theme, const std::string& label);

/// The finite points of a cloud with the number that their colour shows.
struct ScenePoints {
  std::vector<Eigen::Vector3f> positions;
  std::vector<float> values;
  /// Numbers that the ends of the colour map stand for.
  double low = 0.0, high = 1.0;
  /// What the numbers are, with unit; empty if points bring their own colours.
  std::string quantity;
  /// One colour a point.
  std::vector<Color> colors;
};

/// Throws InvalidArgument if the colour asked for needs a channel that the cloud does not have.
ScenePoints collect_points(const geometry::PointCloudView& cloud, const SceneOptions& options);

/// The part of space that is shown.
struct Region {
  Eigen::Vector3d low, high;
  /// Height of the ground as far as the points tell.
  double ground;
  /// Rings around the origin (a scan from a sensor) rather than a grid (a room).
  bool rings;
};

Region find_region(const ScenePoints& points, const Scene& scene, const SceneOptions& options);

/// Puts labels where they hide no other label and little else.
class LabelPlacer {
 public:
  LabelPlacer(Canvas& canvas, const Theme& theme) : canvas_(canvas), theme_(theme) {}
  void keep_free(const Rect& rect) { taken_.push_back(rect); }
  /// Writes a label close to the rectangle of its object, or not at all if there is no room.
  void place(const std::string& text, const Rect& object, Color color);

 private:
  Canvas& canvas_;
  const Theme& theme_;
  std::vector<Rect> taken_;
};

/// The points, low ones first from above and far ones first in perspective.
void draw_points_birdseye(Canvas& canvas, const Theme& theme, const ScenePoints& points,
                          const Projection& projection);
void draw_points_perspective(Canvas& canvas, const Theme& theme, const ScenePoints& points,
                             const Region& region, const Projection& projection);

/// Rings or a grid on the ground, with their distances.
void draw_ground(Canvas& canvas, const Theme& theme, const Region& region,
                 const Projection& projection);

/// The smallest rectangle around a box in the picture; left > right if nothing of it is before the
/// camera.
Rect screen_rect(const Projection& projection, const geometry::Box& box);

/// The directions of x, y and z, and a scale bar if the scale is one number; each in the corner
/// where it meets the boxes least. Drawn before the boxes, so that it hides none. Gives the places
/// that it takes.
std::vector<Rect> draw_furniture(Canvas& canvas, const Theme& theme, const Scene& scene,
                                 const Projection& projection, const Eigen::Vector3d& at,
                                 std::optional<double> pixels_per_metre = {});

/// All boxes of the scene, with labels that keep off the rectangles in `taken`.
void draw_boxes(Canvas& canvas, const Theme& theme, const Scene& scene,
                const Projection& projection, bool labels, const std::vector<Rect>& taken = {});

/// Height of the legend in a picture of that width, and the legend with its top left corner there.
double legend_height(const Theme& theme, const Scene& scene, const ScenePoints& points,
                     double width);
void draw_legend(Canvas& canvas, const Theme& theme, const Scene& scene, const ScenePoints& points,
                 const Rect& rect);

}  // namespace arbox::drawing
