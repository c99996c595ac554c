#include <algorithm>
#include <cmath>

#include "arbox/drawing/internal/axes.h"
#include "arbox/drawing/internal/scene_parts.h"

namespace arbox::drawing {
namespace {

void draw_ground_line(Canvas& canvas, const Projection& projection, const Eigen::Vector3d& from,
                      const Eigen::Vector3d& to, const Stroke& stroke) {
  if (const auto line = projection.segment(from, to)) {
    canvas.line(line->first, line->second, stroke);
  }
}

void draw_ring(Canvas& canvas, const Theme& theme, double radius, double ground,
               const Projection& projection) {
  constexpr int kSteps = 180;
  std::vector<Point> run;
  const Stroke stroke = {.color = theme.grid, .width = 1.2 * theme.unit};
  for (int i = 0; i <= kSteps; ++i) {
    const double angle = 2.0 * M_PI * i / kSteps;
    const auto pixel = projection({radius * std::cos(angle), radius * std::sin(angle), ground});
    if (pixel) {
      run.push_back(*pixel);
    } else {
      canvas.polyline(run, stroke);
      run.clear();
    }
  }
  canvas.polyline(run, stroke);
}

void label_ring(Canvas& canvas, const Theme& theme, double radius, double ground,
                const Projection& projection) {
  const TextStyle style = {.size = 12.0 * theme.unit,
                           .color = theme.soft_ink,
                           .along = Align::kMiddle,
                           .across = Align::kMiddle};
  const std::string text = short_number(radius, 1) + " m";
  // Forward first; where that is outside of the picture, further and further to the side.
  for (const double degrees : {0.0, 45.0, -45.0, 90.0, -90.0, 135.0, -135.0, 180.0}) {
    const double angle = degrees * M_PI / 180.0;
    const auto pixel = projection({radius * std::cos(angle), radius * std::sin(angle), ground});
    if (!pixel) continue;
    const Rect rect = Canvas::text_rect(*pixel, text, style).grown(3.0 * theme.unit);
    const Rect& clip = canvas.clip_rect();
    if (rect.left < clip.left || rect.right > clip.right || rect.top < clip.top ||
        rect.bottom > clip.bottom) {
      continue;
    }
    canvas.fill(rect, theme.panel, 0.75);
    canvas.text(*pixel, text, style);
    return;
  }
}

double ring_step(const Region& region) {
  const double reach = std::max(region.high.head<2>().maxCoeff(), -region.low.head<2>().minCoeff());
  return std::max(1.0, nice_below(reach / 2.5));
}

}  // namespace

void draw_ground(Canvas& canvas, const Theme& theme, const Region& region,
                 const Projection& projection) {
  if (region.rings) {
    const double step = ring_step(region);
    const double reach = std::max(region.low.head<2>().norm(), region.high.head<2>().norm());
    for (double radius = step; radius <= reach; radius += step) {
      draw_ring(canvas, theme, radius, region.ground, projection);
    }
    for (double radius = step; radius <= reach; radius += step) {
      label_ring(canvas, theme, radius, region.ground, projection);
    }
    return;
  }
  const double step = nice_below((region.high - region.low).head<2>().maxCoeff() / 5.0);
  const Stroke stroke = {.color = theme.grid, .width = theme.unit};
  const double z = region.ground;
  const auto first = [&](int axis) { return std::ceil(region.low[axis] / step) * step; };
  for (double x = first(0); x <= region.high.x(); x += step) {
    draw_ground_line(canvas, projection, {x, region.low.y(), z}, {x, region.high.y(), z}, stroke);
  }
  for (double y = first(1); y <= region.high.y(); y += step) {
    draw_ground_line(canvas, projection, {region.low.x(), y, z}, {region.high.x(), y, z}, stroke);
  }
}

}  // namespace arbox::drawing
