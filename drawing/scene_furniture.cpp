#include <algorithm>
#include <array>
#include <limits>

#include "arbox/drawing/internal/axes.h"
#include "arbox/drawing/internal/scene_parts.h"

namespace arbox::drawing {
namespace {

enum Corner { kLowerLeft, kLowerRight, kUpperLeft, kUpperRight };

Rect in_corner(const Rect& view, Corner corner, double width, double height, double margin) {
  const bool right = corner == kLowerRight || corner == kUpperRight;
  const bool upper = corner == kUpperLeft || corner == kUpperRight;
  const double x = right ? view.right - margin - width : view.left + margin;
  const double y = upper ? view.top + margin : view.bottom - margin - height;
  return {x, y, x + width, y + height};
}

double shared_area(const Rect& one, const Rect& other) {
  if (!one.overlaps(other)) return 0.0;
  return (std::min(one.right, other.right) - std::max(one.left, other.left)) *
         (std::min(one.bottom, other.bottom) - std::max(one.top, other.top));
}

/// The place among `corners` that meets the boxes least, the first of equals.
Rect quietest(const Canvas& canvas, const std::array<Corner, 4>& corners, double width,
              double height, double margin, const std::vector<Rect>& boxes,
              const std::vector<Rect>& taken) {
  Rect best;
  double least = std::numeric_limits<double>::infinity();
  for (const Corner corner : corners) {
    const Rect rect = in_corner(canvas.clip_rect(), corner, width, height, margin);
    if (std::any_of(taken.begin(), taken.end(),
                    [&](const Rect& other) { return other.overlaps(rect); })) {
      continue;
    }
    double area = 0.0;
    for (const Rect& box : boxes) area += shared_area(rect, box);
    if (area < least) {
      least = area;
      best = rect;
    }
  }
  return best;
}

Rect draw_scale_bar(Canvas& canvas, const Theme& theme, double pixels_per_metre,
                    const std::vector<Rect>& boxes) {
  const double u = theme.unit;
  const double metres = nice_below(150.0 * u / pixels_per_metre);
  const double length = metres * pixels_per_metre;
  const Rect rect = quietest(canvas, {kLowerLeft, kLowerRight, kUpperLeft, kUpperRight},
                             length + 16.0 * u, 37.0 * u, 9.0 * u, boxes, {});
  const double left = rect.left + 8.0 * u, y = rect.bottom - 9.0 * u;
  canvas.fill(rect, theme.panel, 0.85);
  canvas.fill(Rect{left, y - 2 * u, left + length, y + u}, theme.ink);
  canvas.fill(Rect{left, y - 6 * u, left + 1.5 * u, y + u}, theme.ink);
  canvas.fill(Rect{left + length - 1.5 * u, y - 6 * u, left + length, y + u}, theme.ink);
  canvas.text({left + length / 2, y - 10 * u}, short_number(metres, 3) + " m",
              {.size = 13.0 * u, .color = theme.ink, .along = Align::kMiddle});
  return rect;
}

Rect draw_axes(Canvas& canvas, const Theme& theme, const Projection& projection,
               const Eigen::Vector3d& at, const std::vector<Rect>& boxes,
               const std::vector<Rect>& taken) {
  const double u = theme.unit;
  const auto start = projection(at);
  if (!start) return {};
  const Rect rect = quietest(canvas, {kLowerRight, kLowerLeft, kUpperRight, kUpperLeft}, 88.0 * u,
                             86.0 * u, 0.0, boxes, taken);
  const Point middle(rect.left + 40.0 * u, rect.top + 42.0 * u);
  canvas.fill(rect, theme.panel, 0.85);
  const std::array<const char*, 3> names = {"x", "y", "z"};
  const std::array<Color, 3> colors = {{{200, 50, 40}, {40, 140, 60}, {40, 90, 200}}};
  std::array<Point, 3> ways;
  double longest = 1e-9;
  for (int axis = 0; axis < 3; ++axis) {
    const auto end = projection(at + 0.01 * Eigen::Vector3d::Unit(axis));
    ways[axis] = end ? Point(*end - *start) : Point(0, 0);
    longest = std::max(longest, ways[axis].norm());
  }
  for (int axis = 0; axis < 3; ++axis) {
    const Point way = ways[axis] / longest * 26.0 * u;
    if (way.norm() < 2.0 * u) continue;
    canvas.line(middle, middle + way, {.color = colors[axis], .width = 2.0 * u});
    canvas.text(middle + way + 9.0 * u * way.normalized(), names[axis],
                {.size = 12.0 * u,
                 .color = colors[axis],
                 .bold = true,
                 .along = Align::kMiddle,
                 .across = Align::kMiddle});
  }
  return rect;
}

}  // namespace

std::vector<Rect> draw_furniture(Canvas& canvas, const Theme& theme, const Scene& scene,
                                 const Projection& projection, const Eigen::Vector3d& at,
                                 std::optional<double> pixels_per_metre) {
  std::vector<Rect> boxes;
  for (const auto* group : {&scene.predictions, &scene.truth}) {
    for (const geometry::Detection& detection : *group) {
      boxes.push_back(screen_rect(projection, detection.box));
    }
  }
  std::vector<Rect> taken;
  if (pixels_per_metre) taken.push_back(draw_scale_bar(canvas, theme, *pixels_per_metre, boxes));
  taken.push_back(draw_axes(canvas, theme, projection, at, boxes, taken));
  return taken;
}

}  // namespace arbox::drawing
