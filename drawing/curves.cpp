#include "arbox/drawing/curves.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "arbox/base/error.h"
#include "arbox/drawing/internal/panel.h"

namespace arbox::drawing {
namespace {

constexpr Color kInk = {34, 34, 34};
constexpr Color kPaper = {255, 255, 255};
constexpr double kTitleHeight = 44.0;

void check_axis(const Axis& axis, const std::string& where) {
  for (const auto& end : {axis.low, axis.high}) {
    if (end && (!std::isfinite(*end) || (axis.logarithmic && *end <= 0.0))) {
      throw InvalidArgument(where + ": the ends of the axis must be finite" +
                            (axis.logarithmic ? " and positive" : "") + ", got " +
                            std::to_string(*end));
    }
  }
  if (axis.low && axis.high && !(*axis.low < *axis.high)) {
    throw InvalidArgument(where + ": the low end of the axis must be below its high end, got " +
                          std::to_string(*axis.low) + " and " + std::to_string(*axis.high));
  }
}

void check(const Panel& panel, std::size_t index) {
  const std::string where = "draw_figure: panel " + std::to_string(index);
  check_axis(panel.x, where + ", x");
  check_axis(panel.y, where + ", y");
  for (const Series& series : panel.series) {
    const std::size_t count = series.x.size();
    const bool band = !series.low.empty() || !series.high.empty();
    if (series.y.size() != count ||
        (band && (series.low.size() != count || series.high.size() != count))) {
      throw InvalidArgument(
          where + ", series '" + series.name + "': x, y and the band must be equally long, got " +
          std::to_string(count) + " x and " + std::to_string(series.y.size()) + " y");
    }
  }
  for (const Bars& bars : panel.bars) {
    const bool by_category = bars.edges.empty();
    const std::size_t expected = by_category ? panel.categories.size() : bars.edges.size() - 1;
    if (bars.heights.size() != expected) {
      throw InvalidArgument(where + ", bars '" + bars.name + "': expected " +
                            std::to_string(expected) + " heights (one " +
                            (by_category ? "a category" : "fewer than edges") + "), got " +
                            std::to_string(bars.heights.size()));
    }
    for (std::size_t i = 1; i < bars.edges.size(); ++i) {
      if (!(bars.edges[i - 1] < bars.edges[i])) {
        throw InvalidArgument(where + ", bars '" + bars.name + "': edges must ascend");
      }
    }
  }
}

}  // namespace

Image draw_figure(std::span<const Panel> panels, const FigureOptions& options) {
  if (panels.empty()) throw InvalidArgument("draw_figure: expected at least one panel, got none");
  if (options.panel_width < 120 || options.panel_height < 120 || options.columns < 0) {
    throw InvalidArgument(
        "draw_figure: a panel must be at least 120 x 120 pixels and columns >= 0");
  }
  for (std::size_t i = 0; i < panels.size(); ++i) check(panels[i], i);
  const int count = static_cast<int>(panels.size());
  const int columns = std::min(count, options.columns > 0 ? options.columns : 3);
  const int rows = (count + columns - 1) / columns;
  const int top = options.title.empty() ? 0 : static_cast<int>(kTitleHeight);
  Canvas canvas(columns * options.panel_width, rows * options.panel_height + top, kPaper);
  canvas.text({canvas.width() / 2.0, 16.0}, options.title,
              {.size = 19.0,
               .color = kInk,
               .bold = true,
               .along = Align::kMiddle,
               .across = Align::kBegin});
  for (int i = 0; i < count; ++i) {
    const double left = i % columns * options.panel_width;
    const double upper = top + i / columns * options.panel_height;
    draw_panel(canvas, panels[i],
               {left, upper, left + options.panel_width, upper + options.panel_height});
  }
  return canvas.take();
}

Bars histogram(std::span<const double> values, int bins, const std::string& name,
               std::optional<double> low, std::optional<double> high) {
  if (bins < 1) throw InvalidArgument("histogram: bins must be at least 1");
  double first = std::numeric_limits<double>::infinity(), last = -first;
  for (const double value : values) {
    if (!std::isfinite(value)) continue;
    first = std::min(first, value);
    last = std::max(last, value);
  }
  if (!(first <= last)) first = 0.0, last = 1.0;
  first = low.value_or(first);
  last = high.value_or(last);
  if (!(first < last) && !low && !high) first -= 0.5, last += 0.5;
  if (!(first < last) || !std::isfinite(last - first)) {
    throw InvalidArgument("histogram: low must be below high, got " + std::to_string(first) +
                          " and " + std::to_string(last));
  }
  Bars bars = {.name = name, .heights = std::vector<double>(bins, 0.0)};
  for (int i = 0; i <= bins; ++i) bars.edges.push_back(std::lerp(first, last, i / double(bins)));
  for (const double value : values) {
    if (!std::isfinite(value) || value < first || value > last) continue;
    const int bin = static_cast<int>((value - first) / (last - first) * bins);
    ++bars.heights[std::min(bin, bins - 1)];
  }
  return bars;
}

}  // namespace arbox::drawing
