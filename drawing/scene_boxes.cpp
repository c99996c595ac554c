#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numeric>

#include "arbox/drawing/internal/scene_parts.h"

namespace arbox::drawing {
namespace {

using geometry::Box;
using geometry::Detection;

constexpr std::array<std::array<int, 2>, 12> kEdges = {{{0, 1},
                                                        {2, 3},
                                                        {4, 5},
                                                        {6, 7},
                                                        {0, 2},
                                                        {1, 3},
                                                        {4, 6},
                                                        {5, 7},
                                                        {0, 4},
                                                        {1, 5},
                                                        {2, 6},
                                                        {3, 7}}};

void draw_wireframe(Canvas& canvas, const Projection& projection, const Box& box,
                    const Stroke& stroke) {
  const auto corners = geometry::corners(box);
  for (const auto& [a, b] : kEdges) {
    if (const auto edge = projection.segment(corners[a], corners[b])) {
      canvas.line(edge->first, edge->second, stroke);
    }
  }
}

std::vector<Eigen::Vector3d> in_frame(const Box& box, std::initializer_list<Eigen::Vector3d> own) {
  std::vector<Eigen::Vector3d> points;
  for (const Eigen::Vector3d& p : own) {
    points.push_back(box.center + box.rotation * p.cwiseProduct(box.size / 2));
  }
  return points;
}

// A pale front face and an arrow head on the top face tell where the box points to.
void draw_heading(Canvas& canvas, const Theme& theme, const Projection& projection, const Box& box,
                  Color color) {
  // In halves of the box: as on a car, but not half of a bed.
  const double nose = std::min(0.5, 0.9 * box.size.y() / box.size.x());
  const double wing = std::min(0.62, 0.7 * nose * box.size.x() / box.size.y());
  canvas.fill(projection.polygon(in_frame(box, {{1, -1, -1}, {1, 1, -1}, {1, 1, 1}, {1, -1, 1}})),
              color, theme.front_opacity);
  canvas.fill(projection.polygon(
                  in_frame(box, {{0.94, 0, 1}, {0.94 - nose, wing, 1}, {0.94 - nose, -wing, 1}})),
              color, 0.55);
}

void draw_top(Canvas& canvas, const Projection& projection, const Box& box, Color color) {
  canvas.fill(projection.polygon(in_frame(box, {{1, -1, 1}, {1, 1, 1}, {-1, 1, 1}, {-1, -1, 1}})),
              color, 0.16);
}

void draw_uncertainty(Canvas& canvas, const Theme& theme, const Projection& projection,
                      const Detection& detection, Color color) {
  const double faint =
      std::clamp(2.5 / static_cast<double>(detection.samples.size() + 1), 0.05, 0.3);
  for (const Box& sample : detection.samples) {
    draw_wireframe(canvas, projection, sample,
                   {.color = color, .width = 0.9 * theme.unit, .opacity = faint});
  }
  for (const geometry::QuantileBox& quantile : detection.quantile_boxes) {
    draw_wireframe(canvas, projection, quantile.box,
                   {.color = mix(color, theme.ink, 0.25),
                    .width = 1.1 * theme.unit,
                    .opacity = 0.85 - 0.4 * std::clamp(quantile.q, 0.0, 1.0),
                    .dash = 0.6 * theme.unit,
                    .gap = 3.0 * theme.unit});
  }
  for (const geometry::ConfidenceBox& confidence : detection.confidence_boxes) {
    draw_wireframe(canvas, projection, confidence.box,
                   {.color = mix(color, theme.panel, 0.25),
                    .width = 1.3 * theme.unit,
                    .dash = 8.0 * theme.unit,
                    .gap = 5.0 * theme.unit});
  }
}

void draw_prediction(Canvas& canvas, const Theme& theme, const Projection& projection,
                     const Detection& detection, Color color) {
  draw_uncertainty(canvas, theme, projection, detection, color);
  draw_top(canvas, projection, detection.box, color);
  draw_heading(canvas, theme, projection, detection.box, color);
  draw_wireframe(canvas, projection, detection.box,
                 {.color = theme.panel, .width = 3.4 * theme.unit, .opacity = 0.55});
  draw_wireframe(canvas, projection, detection.box, {.color = color, .width = 1.9 * theme.unit});
}

void draw_truth(Canvas& canvas, const Theme& theme, const Projection& projection, const Box& box,
                Color color) {
  draw_wireframe(canvas, projection, box,
                 {.color = theme.panel, .width = 3.2 * theme.unit, .opacity = 0.5});
  draw_wireframe(canvas, projection, box,
                 {.color = color,
                  .width = 1.7 * theme.unit,
                  .dash = 5.0 * theme.unit,
                  .gap = 4.0 * theme.unit});
}

std::string label_text(const Detection& detection, bool score) {
  if (!score) return detection.label;
  char number[32];
  std::snprintf(number, sizeof number, "%.2f", detection.score);
  return detection.label.empty() ? number : detection.label + " " + number;
}

std::vector<std::size_t> far_to_near(const std::vector<Detection>& detections,
                                     const Projection& projection) {
  std::vector<std::size_t> order(detections.size());
  std::iota(order.begin(), order.end(), 0u);
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return projection.homogeneous(detections[a].box.center).z() >
           projection.homogeneous(detections[b].box.center).z();
  });
  return order;
}

}  // namespace

Rect screen_rect(const Projection& projection, const Box& box) {
  Rect rect = {1e9, 1e9, -1e9, -1e9};
  const auto corners = geometry::corners(box);
  for (const auto& [a, b] : kEdges) {
    const auto edge = projection.segment(corners[a], corners[b]);
    if (!edge) continue;
    for (const Point& p : {edge->first, edge->second}) {
      rect = {std::min(rect.left, p.x()), std::min(rect.top, p.y()), std::max(rect.right, p.x()),
              std::max(rect.bottom, p.y())};
    }
  }
  return rect;
}

void LabelPlacer::place(const std::string& text, const Rect& object, Color color) {
  if (text.empty()) return;
  const double gap = 3.0 * theme_.unit;
  const TextStyle style = {.size = 13.0 * theme_.unit,
                           .color = mix(color, theme_.ink, 0.35),
                           .bold = true,
                           .across = Align::kBegin};
  const Rect size = Canvas::text_rect({0, 0}, text, style);
  const double w = size.width() + 2 * gap, h = size.height() + 1.4 * gap;
  const Rect& clip = canvas_.clip_rect();
  const Rect shown = {std::max(object.left, clip.left), std::max(object.top, clip.top),
                      std::min(object.right, clip.right), std::min(object.bottom, clip.bottom)};
  if (shown.left >= shown.right || shown.top >= shown.bottom) return;
  const Point middle = shown.center();
  for (double away : {0.0, 1.0, 2.0, 3.2}) {
    const double d = gap + away * h;
    for (const Point& corner :
         {Point(middle.x() - w / 2, shown.top - d - h), Point(shown.right + d, middle.y() - h / 2),
          Point(shown.left - d - w, middle.y() - h / 2),
          Point(middle.x() - w / 2, shown.bottom + d), Point(shown.right + d, shown.top - d - h),
          Point(shown.left - d - w, shown.top - d - h), Point(shown.right + d, shown.bottom + d),
          Point(shown.left - d - w, shown.bottom + d)}) {
      const Rect rect = {corner.x(), corner.y(), corner.x() + w, corner.y() + h};
      if (rect.left < clip.left || rect.right > clip.right || rect.top < clip.top ||
          rect.bottom > clip.bottom ||
          std::any_of(taken_.begin(), taken_.end(),
                      [&](const Rect& other) { return other.overlaps(rect); })) {
        continue;
      }
      if (away > 0.0) {
        const Point end(std::clamp(middle.x(), rect.left, rect.right),
                        std::clamp(middle.y(), rect.top, rect.bottom));
        canvas_.line(middle, end, {.color = color, .width = theme_.unit, .opacity = 0.7});
      }
      canvas_.fill(rect, theme_.panel, 0.82);
      canvas_.text({rect.left + gap, rect.top + 0.9 * gap}, text, style);
      taken_.push_back(rect);
      return;
    }
  }
}

void draw_boxes(Canvas& canvas, const Theme& theme, const Scene& scene,
                const Projection& projection, bool labels, const std::vector<Rect>& taken) {
  const bool alone = scene.predictions.empty();
  const auto color_of = [&](const Detection& detection) {
    return theme_color(theme, detection.label);
  };
  for (const std::size_t i : far_to_near(scene.predictions, projection)) {
    const Detection& detection = scene.predictions[i];
    draw_prediction(canvas, theme, projection, detection, color_of(detection));
  }
  for (const std::size_t i : far_to_near(scene.truth, projection)) {
    const Detection& detection = scene.truth[i];
    const bool front = scene.truth_has_front.empty() || scene.truth_has_front[i];
    if (alone && front) draw_heading(canvas, theme, projection, detection.box, color_of(detection));
    draw_truth(canvas, theme, projection, detection.box, alone ? color_of(detection) : theme.ink);
  }
  if (!labels) return;
  LabelPlacer placer(canvas, theme);
  for (const Rect& rect : taken) placer.keep_free(rect);
  const std::vector<Detection>& named = alone ? scene.truth : scene.predictions;
  for (const Detection& detection : named) {
    placer.keep_free(screen_rect(projection, detection.box).grown(-1.0));
  }
  std::vector<std::size_t> order(named.size());
  std::iota(order.begin(), order.end(), 0u);
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return named[a].score > named[b].score; });
  for (const std::size_t i : order) {
    placer.place(label_text(named[i], !alone), screen_rect(projection, named[i].box),
                 color_of(named[i]));
  }
}

}  // namespace arbox::drawing
