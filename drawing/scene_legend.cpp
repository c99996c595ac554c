#include <algorithm>
#include <cmath>
#include <functional>
#include <set>

#include "arbox/drawing/internal/axes.h"
#include "arbox/drawing/internal/scene_parts.h"

namespace arbox::drawing {
namespace {

constexpr double kRow = 26.0;

struct Entry {
  std::string text;
  double swatch;
  /// Draws the swatch with its left middle at a point.
  std::function<void(Canvas&, const Point&)> draw;
};

std::string joined(const std::set<double>& numbers) {
  std::string text;
  for (const double number : numbers) text += (text.empty() ? "" : ", ") + short_number(number, 3);
  return text;
}

Entry line_entry(const Theme& theme, std::string text, const Stroke& stroke) {
  const double length = 24.0 * theme.unit;
  return {std::move(text), length, [stroke, length](Canvas& canvas, const Point& at) {
            canvas.line(at, at + Point(length, 0), stroke);
          }};
}

Entry class_entry(const Theme& theme, const std::string& name, bool dashed) {
  const double u = theme.unit;
  const Color color = theme_color(theme, name);
  return {name.empty() ? "unnamed" : name, 18.0 * u, [=](Canvas& canvas, const Point& at) {
            const Rect rect = {at.x(), at.y() - 6 * u, at.x() + 18 * u, at.y() + 6 * u};
            const std::array<Point, 4> outline = {
                Point(rect.left, rect.top), Point(rect.right, rect.top),
                Point(rect.right, rect.bottom), Point(rect.left, rect.bottom)};
            canvas.fill(rect, color, 0.25);
            canvas.polyline(
                outline,
                {.color = color, .width = 1.7 * u, .dash = 4.0 * u, .gap = dashed ? 3.2 * u : 0.0},
                true);
          }};
}

Entry ramp_entry(const Theme& theme, const ScenePoints& points) {
  const double u = theme.unit, length = 130.0 * u;
  const int digits = points.high - points.low < 2.0 ? 2 : 1;
  const std::string low = short_number(points.low, digits),
                    high = short_number(points.high, digits);
  const TextStyle style = {.size = 13.0 * u, .color = theme.soft_ink, .across = Align::kMiddle};
  const double low_width = Canvas::text_rect({0, 0}, low, style).width() + 7.0 * u;
  const double high_width = Canvas::text_rect({0, 0}, high, style).width() + 7.0 * u;
  const bool dark = theme.dark;
  return {points.quantity, low_width + length + high_width, [=](Canvas& canvas, const Point& at) {
            canvas.text(at, low, style);
            const double left = std::round(at.x() + low_width);
            for (double x = 0.0; x < length; ++x) {
              canvas.fill(Rect{left + x, at.y() - 5 * u, left + x + 1, at.y() + 5 * u},
                          map_color(x / length, dark));
            }
            canvas.text({left + length + 7.0 * u, at.y()}, high, style);
          }};
}

std::vector<Entry> entries(const Theme& theme, const Scene& scene, const ScenePoints& points) {
  const double u = theme.unit;
  const bool alone = scene.predictions.empty();
  std::set<std::string> classes;
  std::set<double> quantiles, confidences;
  bool samples = false;
  for (const geometry::Detection& detection : alone ? scene.truth : scene.predictions) {
    classes.insert(detection.label);
    if (alone) continue;
    samples = samples || !detection.samples.empty();
    for (const auto& quantile : detection.quantile_boxes) quantiles.insert(quantile.q);
    for (const auto& confidence : detection.confidence_boxes) confidences.insert(confidence.p);
  }
  std::vector<Entry> result;
  for (const std::string& name : classes) result.push_back(class_entry(theme, name, alone));
  if (!scene.truth.empty()) {
    result.push_back(
        line_entry(theme, "ground truth",
                   {.color = theme.ink, .width = 1.7 * u, .dash = 5.0 * u, .gap = 4.0 * u}));
  }
  if (!quantiles.empty()) {
    result.push_back(
        line_entry(theme, "quantile box, q = " + joined(quantiles),
                   {.color = theme.soft_ink, .width = 1.3 * u, .dash = 0.6 * u, .gap = 3.0 * u}));
  }
  if (!confidences.empty()) {
    result.push_back(
        line_entry(theme, "confidence box, p = " + joined(confidences),
                   {.color = theme.soft_ink, .width = 1.3 * u, .dash = 8.0 * u, .gap = 4.0 * u}));
  }
  if (samples) {
    result.push_back(
        line_entry(theme, "samples", {.color = theme.soft_ink, .width = 1.0 * u, .opacity = 0.5}));
  }
  if (!points.quantity.empty()) result.push_back(ramp_entry(theme, points));
  return result;
}

TextStyle legend_style(const Theme& theme) {
  return {.size = 13.5 * theme.unit, .color = theme.ink, .across = Align::kMiddle};
}

// Calls place(entry, left, row) for each entry, filling rows; gives the number of rows.
template <class Place>
int lay_out(const std::vector<Entry>& all, const Theme& theme, double width, const Place& place) {
  double x = 0.0;
  int row = 0;
  for (const Entry& entry : all) {
    const double needed = entry.swatch + 8.0 * theme.unit +
                          Canvas::text_rect({0, 0}, entry.text, legend_style(theme)).width();
    if (x > 0.0 && x + needed > width) {
      x = 0.0;
      ++row;
    }
    place(entry, x, row);
    x += needed + 26.0 * theme.unit;
  }
  return all.empty() ? 0 : row + 1;
}

}  // namespace

double legend_height(const Theme& theme, const Scene& scene, const ScenePoints& points,
                     double width) {
  const int rows =
      lay_out(entries(theme, scene, points), theme, width, [](const Entry&, double, int) {});
  return rows * kRow * theme.unit;
}

void draw_legend(Canvas& canvas, const Theme& theme, const Scene& scene, const ScenePoints& points,
                 const Rect& rect) {
  lay_out(entries(theme, scene, points), theme, rect.width(),
          [&](const Entry& entry, double x, int row) {
            const Point at(rect.left + x, rect.top + (row + 0.5) * kRow * theme.unit);
            entry.draw(canvas, at);
            canvas.text(at + Point(entry.swatch + 8.0 * theme.unit, 0), entry.text,
                        legend_style(theme));
          });
}

}  // namespace arbox::drawing
