#include "arbox/drawing/internal/panel.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "arbox/drawing/internal/axes.h"

namespace arbox::drawing {
namespace {

constexpr Color kInk = {34, 34, 34};
constexpr Color kSoftInk = {90, 90, 90};
constexpr Color kGrid = {228, 228, 228};
constexpr Color kPaper = {255, 255, 255};
constexpr double kTextSize = 14.0;
constexpr double kLegendRow = 21.0;
constexpr double kSwatch = 26.0;
constexpr TextStyle kLegendStyle = {.size = kTextSize - 1, .color = kInk, .across = Align::kMiddle};

bool drawable(double value, bool logarithmic) {
  return std::isfinite(value) && (!logarithmic || value > 0.0);
}

struct Scale {
  double low = 0.0, high = 1.0;
  bool logarithmic = false;
  double from = 0.0, to = 1.0;

  double operator()(double value) const {
    if (!drawable(value, logarithmic)) return std::numeric_limits<double>::quiet_NaN();
    const double t =
        logarithmic ? std::log(value / low) / std::log(high / low) : (value - low) / (high - low);
    return from + t * (to - from);
  }
  std::vector<double> ticks(double spacing) const {
    if (logarithmic) return logarithmic_ticks(low, high);
    const double length = std::abs(to - from);
    return nice_ticks(low, high, std::max(2, static_cast<int>(length / spacing)));
  }
};

Scale fit(const Axis& axis, const std::vector<double>& values, bool from_zero, double margin) {
  Scale scale;
  scale.logarithmic = axis.logarithmic;
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const double value : values) {
    if (!drawable(value, axis.logarithmic)) continue;
    low = std::min(low, value);
    high = std::max(high, value);
  }
  if (from_zero && !axis.logarithmic && low <= high) {
    low = std::min(low, 0.0);
    high = std::max(high, 0.0);
  }
  if (!(low <= high)) {
    low = axis.logarithmic ? 1.0 : 0.0;
    high = axis.logarithmic ? 10.0 : 1.0;
  }
  if (axis.logarithmic) {
    const double factor = std::max(1.05, std::pow(high / low, margin));
    low /= factor;
    high *= factor;
  } else {
    const double room = high > low ? margin * (high - low) : std::max(0.5, 0.05 * std::abs(high));
    if (!(from_zero && low == 0.0)) low -= room;
    if (!(from_zero && high == 0.0)) high += room;
  }
  scale.low = axis.low.value_or(low);
  scale.high = axis.high.value_or(high);
  // One given end may lie beyond the data.
  if (!(scale.low < scale.high)) {
    if (axis.low)
      scale.high = axis.logarithmic ? 10.0 * scale.low : scale.low + 1.0;
    else
      scale.low = axis.logarithmic ? scale.high / 10.0 : scale.high - 1.0;
  }
  return scale;
}

struct Entry {
  std::string name;
  Color color;
  LineStyle line;
  bool markers;
  bool bar;
};

class PanelPainter {
 public:
  PanelPainter(Canvas& canvas, const Panel& panel, const Rect& room)
      : canvas_(canvas), panel_(panel), room_(room) {}

  void draw() {
    fit_scales();
    place();
    draw_axes();
    canvas_.clip(plot_.grown(1.0));
    draw_bars();
    if (panel_.diagonal) draw_diagonal();
    draw_series();
    canvas_.clip_to_all();
    draw_legend();
  }

 private:
  void fit_scales() {
    std::vector<double> xs, ys;
    for (const Series& series : panel_.series) {
      xs.insert(xs.end(), series.x.begin(), series.x.end());
      for (const auto* values : {&series.y, &series.low, &series.high}) {
        ys.insert(ys.end(), values->begin(), values->end());
      }
    }
    for (const Bars& bars : panel_.bars) {
      xs.insert(xs.end(), bars.edges.begin(), bars.edges.end());
      ys.insert(ys.end(), bars.heights.begin(), bars.heights.end());
    }
    x_ = fit(panel_.x, xs, false, panel_.series.empty() ? 0.02 : 0.03);
    y_ = fit(panel_.y, ys, !panel_.bars.empty(), 0.06);
    if (!panel_.categories.empty()) {
      x_.logarithmic = false;
      x_.low = -0.5;
      x_.high = static_cast<double>(panel_.categories.size()) - 0.5;
    }
  }

  void place() {
    plot_ = {room_.left + 24.0, room_.top + (panel_.title.empty() ? 14.0 : 38.0),
             room_.right - 20.0, room_.bottom - (panel_.x.label.empty() ? 34.0 : 58.0)};
    if (!panel_.y.label.empty()) plot_.left += 26.0;
    if (panel_.legend_above) plot_.top += kLegendRow + 2.0;
    y_.from = plot_.bottom;
    y_.to = plot_.top;
    y_ticks_ = y_.ticks(46.0);
    double widest = 0.0;
    for (const std::string& text : tick_texts(y_ticks_)) {
      widest = std::max(widest, Canvas::text_rect({0, 0}, text, {.size = kTextSize - 1}).width());
    }
    plot_.left = std::min(plot_.left + widest, plot_.right - 20.0);
    x_.from = plot_.left;
    x_.to = plot_.right;
  }

  void draw_axes() {
    const TextStyle tick_style = {.size = kTextSize - 1, .color = kSoftInk};
    const std::vector<std::string> y_texts = tick_texts(y_ticks_);
    for (std::size_t i = 0; i < y_ticks_.size(); ++i) {
      const double y = std::round(y_(y_ticks_[i])) + 0.5;
      canvas_.line({plot_.left, y}, {plot_.right, y}, {.color = kGrid});
      TextStyle style = tick_style;
      style.along = Align::kEnd;
      style.across = Align::kMiddle;
      canvas_.text({plot_.left - 8.0, y}, y_texts[i], style);
    }
    TextStyle below = tick_style;
    below.along = Align::kMiddle;
    below.across = Align::kBegin;
    if (panel_.categories.empty()) {
      const std::vector<double> ticks = x_.ticks(78.0);
      const std::vector<std::string> texts = tick_texts(ticks);
      for (std::size_t i = 0; i < ticks.size(); ++i) {
        const double x = std::round(x_(ticks[i])) + 0.5;
        canvas_.line({x, plot_.top}, {x, plot_.bottom}, {.color = kGrid});
        canvas_.text({x, plot_.bottom + 9.0}, texts[i], below);
      }
    } else {
      for (std::size_t i = 0; i < panel_.categories.size(); ++i) {
        canvas_.text({x_(static_cast<double>(i)), plot_.bottom + 9.0}, panel_.categories[i], below);
      }
    }
    const double left = std::round(plot_.left) + 0.5, bottom = std::round(plot_.bottom) + 0.5;
    canvas_.line({left, plot_.top}, {left, bottom}, {.color = kSoftInk});
    canvas_.line({left, bottom}, {plot_.right, bottom}, {.color = kSoftInk});
    draw_labels();
  }

  void draw_labels() {
    TextStyle style = {.size = kTextSize, .color = kInk, .along = Align::kMiddle};
    style.across = Align::kBegin;
    canvas_.text({plot_.center().x(), plot_.bottom + 33.0}, panel_.x.label, style);
    style.upward = true;
    canvas_.text({room_.left + 12.0, plot_.center().y()}, panel_.y.label, style);
    style.upward = false;
    style.bold = true;
    style.size = kTextSize + 1;
    canvas_.text({plot_.center().x(), room_.top + 14.0}, panel_.title, style);
  }

  Color next_color(const std::optional<Color>& given) {
    return given ? *given : palette_color(next_color_++);
  }

  void draw_bars() {
    std::size_t groups = 0, group = 0;
    for (const Bars& bars : panel_.bars) groups += bars.edges.empty();
    for (const Bars& bars : panel_.bars) {
      const Color color = next_color(bars.color);
      const double zero = y_.logarithmic ? plot_.bottom : y_(0.0);
      const double opacity = bars.edges.empty() || panel_.bars.size() == 1 ? 0.9 : 0.55;
      for (std::size_t i = 0; i < bars.heights.size(); ++i) {
        const double y = y_(bars.heights[i]);
        double low, high;
        if (bars.edges.empty()) {
          const double width = 0.8 / static_cast<double>(groups);
          low = x_(static_cast<double>(i) - 0.4 + width * static_cast<double>(group)) + 0.5;
          high = x_(static_cast<double>(i) - 0.4 + width * static_cast<double>(group + 1)) - 0.5;
        } else {
          low = x_(bars.edges[i]) + 0.5;
          high = std::max(low + 0.5, x_(bars.edges[i + 1]) - 0.5);
        }
        canvas_.fill(Rect{low, std::min(y, zero), high, std::max(y, zero)}, color, opacity);
      }
      group += bars.edges.empty();
      entries_.push_back({bars.name, color, LineStyle::kNone, false, true});
    }
  }

  void draw_diagonal() {
    const double low = std::max(x_.low, y_.low), high = std::min(x_.high, y_.high);
    canvas_.line({x_(low), y_(low)}, {x_(high), y_(high)},
                 {.color = {130, 130, 130}, .width = 1.2, .dash = 5.0, .gap = 5.0});
  }

  static Stroke stroke(Color color, LineStyle line) {
    Stroke result = {.color = color, .width = 2.0};
    if (line == LineStyle::kDashed) result.dash = 7.0, result.gap = 6.0;
    if (line == LineStyle::kDotted) result.dash = 0.5, result.gap = 4.5;
    return result;
  }

  void draw_series() {
    for (const Series& series : panel_.series) {
      const Color color = next_color(series.color);
      std::vector<Point> points, low, high;
      for (std::size_t i = 0; i < series.x.size(); ++i) {
        points.emplace_back(x_(series.x[i]), y_(series.y[i]));
        if (series.low.empty()) continue;
        low.emplace_back(points.back().x(), y_(series.low[i]));
        high.emplace_back(points.back().x(), y_(series.high[i]));
      }
      canvas_.fill_between(high, low, color, 0.18);
      if (series.line != LineStyle::kNone) canvas_.polyline(points, stroke(color, series.line));
      if (series.markers) {
        for (const Point& point : points) canvas_.disc(point, 3.5, color, 0.85);
      }
      entries_.push_back({series.name, color, series.line, series.markers, false});
    }
  }

  // The emptiest of four corners, by the number of data points that the legend would hide.
  Rect legend_place(double width, double height) const {
    const double gap = 12.0;
    const double right = plot_.right - gap - width, bottom = plot_.bottom - gap - height;
    const double left = plot_.left + gap, top = plot_.top + gap;
    Rect best;
    double least = std::numeric_limits<double>::infinity();
    for (const Point& corner :
         {Point(right, top), Point(left, bottom), Point(left, top), Point(right, bottom)}) {
      const Rect rect = {corner.x(), corner.y(), corner.x() + width, corner.y() + height};
      const double cost = hidden(rect);
      if (cost < least) least = cost, best = rect;
    }
    return best;
  }

  double hidden(const Rect& rect) const {
    double count = 0.0;
    for (const Series& series : panel_.series) {
      Point previous(NAN, NAN);
      for (std::size_t i = 0; i < series.x.size(); ++i) {
        const Point point(x_(series.x[i]), y_(series.y[i]));
        const int steps = previous.allFinite() && series.line != LineStyle::kNone ? 16 : 1;
        for (int step = 1; step <= steps; ++step) {
          const Point p = steps == 1 ? point : Point(previous + (point - previous) * step / steps);
          const Rect dot = {p.x() - 1.0, p.y() - 1.0, p.x() + 1.0, p.y() + 1.0};
          if (p.allFinite() && rect.overlaps(dot)) count += 1.0 / steps;
        }
        previous = point;
      }
    }
    for (const Bars& bars : panel_.bars) {
      for (std::size_t i = 0; i < bars.heights.size(); ++i) {
        const double low = bars.edges.empty() ? static_cast<double>(i) - 0.4 : bars.edges[i];
        const double high = bars.edges.empty() ? static_cast<double>(i) + 0.4 : bars.edges[i + 1];
        const Rect bar = {x_(low), y_(bars.heights[i]), x_(high), plot_.bottom};
        if (rect.overlaps(bar)) count += 1.0;
      }
    }
    return count;
  }

  void draw_legend() {
    std::erase_if(entries_, [](const Entry& entry) { return entry.name.empty(); });
    if (entries_.empty()) return;
    if (panel_.legend_above) {
      Point place(plot_.left, plot_.top - kLegendRow / 2 - 2.0);
      for (const Entry& entry : entries_) {
        draw_entry(entry, place);
        place.x() += entry_width(entry) + 16.0;
      }
      return;
    }
    double widest = 0.0;
    for (const Entry& entry : entries_) widest = std::max(widest, entry_width(entry));
    const Rect rect =
        legend_place(widest + 18.0, kLegendRow * static_cast<double>(entries_.size()) + 8.0);
    canvas_.fill(rect, {200, 200, 200}, 0.9);
    canvas_.fill(rect.grown(-1.0), kPaper, 0.95);
    Point place(rect.left + 9.0, rect.top + 4.0 + kLegendRow / 2);
    for (const Entry& entry : entries_) {
      draw_entry(entry, place);
      place.y() += kLegendRow;
    }
  }

  static double entry_width(const Entry& entry) {
    return kSwatch + 8.0 + Canvas::text_rect({0, 0}, entry.name, kLegendStyle).width();
  }

  /// `place`: the middle of its left end.
  void draw_entry(const Entry& entry, const Point& place) {
    const double left = place.x(), y = place.y();
    if (entry.bar) canvas_.fill(Rect{left + 6, y - 6, left + 20, y + 6}, entry.color, 0.9);
    if (!entry.bar && entry.line != LineStyle::kNone) {
      canvas_.line({left, y}, {left + kSwatch, y}, stroke(entry.color, entry.line));
    }
    if (entry.markers) canvas_.disc({left + kSwatch / 2, y}, 3.5, entry.color);
    canvas_.text({left + kSwatch + 8.0, y}, entry.name, kLegendStyle);
  }

  Canvas& canvas_;
  const Panel& panel_;
  Rect room_, plot_;
  Scale x_, y_;
  std::vector<double> y_ticks_;
  std::vector<Entry> entries_;
  int next_color_ = 0;
};

}  // namespace

void draw_panel(Canvas& canvas, const Panel& panel, const Rect& room) {
  PanelPainter(canvas, panel, room).draw();
}

}  // namespace arbox::drawing
