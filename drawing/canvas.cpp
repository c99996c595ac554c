#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "arbox/drawing/internal/canvas.h"
#include "arbox/drawing/internal/font.h"

namespace arbox::drawing {
namespace {

std::uint8_t blended(std::uint8_t below, std::uint8_t above, double coverage) {
  return static_cast<std::uint8_t>(below + (above - below) * coverage + 0.5);
}

// Share of the unit cell at `cell` that lies within [low, high].
double overlap_1d(int cell, double low, double high) {
  return std::max(0.0, std::min(cell + 1.0, high) - std::max<double>(cell, low));
}

int clamped_floor(double value, int low, int high) {
  return static_cast<int>(std::floor(std::clamp<double>(value, low, high)));
}

// Cuts the segment to the rectangle (Liang and Barsky); false if nothing is left.
bool cut_to(const Rect& rect, Point& from, Point& to) {
  const Point direction = to - from;
  double enter = 0.0, leave = 1.0;
  const auto cut = [&](double step, double room) {
    if (step == 0.0) return room >= 0.0;
    const double t = room / step;
    if (step > 0.0)
      leave = std::min(leave, t);
    else
      enter = std::max(enter, t);
    return enter <= leave;
  };
  if (!cut(-direction.x(), from.x() - rect.left) || !cut(direction.x(), rect.right - from.x()) ||
      !cut(-direction.y(), from.y() - rect.top) || !cut(direction.y(), rect.bottom - from.y())) {
    return false;
  }
  to = from + leave * direction;
  from += enter * direction;
  return true;
}

}  // namespace

Canvas::Canvas(int width, int height, Color background)
    : image_(width, height, background),
      mask_(static_cast<std::size_t>(width) * height, 0.0f),
      row_first_(height, width),
      row_last_(height, -1) {
  clip_to_all();
}

void Canvas::clip(const Rect& rect) {
  clip_left_ = clamped_floor(rect.left, 0, width());
  clip_top_ = clamped_floor(rect.top, 0, height());
  clip_right_ = clamped_floor(std::ceil(rect.right), clip_left_, width());
  clip_bottom_ = clamped_floor(std::ceil(rect.bottom), clip_top_, height());
  clip_ = {double(clip_left_), double(clip_top_), double(clip_right_), double(clip_bottom_)};
}

void Canvas::clip_to_all() { clip({0, 0, double(width()), double(height())}); }

void Canvas::blend(int x, int y, Color color, double coverage) {
  std::uint8_t* pixel = &image_.pixels[3 * (static_cast<std::size_t>(y) * image_.width + x)];
  pixel[0] = blended(pixel[0], color.r, coverage);
  pixel[1] = blended(pixel[1], color.g, coverage);
  pixel[2] = blended(pixel[2], color.b, coverage);
}

void Canvas::fill(const Rect& rect, Color color, double opacity) {
  if (!std::isfinite(rect.left + rect.top + rect.right + rect.bottom)) return;
  const int bottom = clamped_floor(std::ceil(rect.bottom), clip_top_, clip_bottom_);
  const int right = clamped_floor(std::ceil(rect.right), clip_left_, clip_right_);
  for (int y = clamped_floor(rect.top, clip_top_, clip_bottom_); y < bottom; ++y) {
    const double rows = opacity * overlap_1d(y, rect.top, rect.bottom);
    for (int x = clamped_floor(rect.left, clip_left_, clip_right_); x < right; ++x) {
      blend(x, y, color, rows * overlap_1d(x, rect.left, rect.right));
    }
  }
}

void Canvas::fill(std::span<const Point> convex, Color color, double opacity) {
  const std::size_t count = convex.size();
  if (count < 3) return;
  Point low = convex[0], high = convex[0];
  double area = 0.0;
  for (std::size_t i = 0; i < count; ++i) {
    const Point& a = convex[i];
    const Point& b = convex[(i + 1) % count];
    if (!a.allFinite()) return;
    low = low.cwiseMin(a);
    high = high.cwiseMax(a);
    area += a.x() * b.y() - a.y() * b.x();
  }
  const double side = area < 0.0 ? -1.0 : 1.0;
  std::vector<Eigen::Vector3d> edges;  // inward normal and offset
  for (std::size_t i = 0; i < count; ++i) {
    const Point along = convex[(i + 1) % count] - convex[i];
    if (along.norm() < 1e-9) continue;
    const Point normal = side * Point(-along.y(), along.x()).normalized();
    edges.emplace_back(normal.x(), normal.y(), 0.5 - normal.dot(convex[i]));
  }
  const int bottom = clamped_floor(high.y() + 1.0, clip_top_, clip_bottom_);
  const int right = clamped_floor(high.x() + 1.0, clip_left_, clip_right_);
  for (int y = clamped_floor(low.y(), clip_top_, clip_bottom_); y < bottom; ++y) {
    for (int x = clamped_floor(low.x(), clip_left_, clip_right_); x < right; ++x) {
      double coverage = 1.0;
      for (const Eigen::Vector3d& edge : edges) {
        coverage = std::min(coverage, edge.x() * (x + 0.5) + edge.y() * (y + 0.5) + edge.z());
        if (coverage <= 0.0) break;
      }
      if (coverage > 0.0) blend(x, y, color, opacity * coverage);
    }
  }
}

void Canvas::fill_between(std::span<const Point> upper, std::span<const Point> lower, Color color,
                          double opacity) {
  for (std::size_t i = 1; i < std::min(upper.size(), lower.size()); ++i) {
    const double from = upper[i - 1].x(), to = upper[i].x();
    if (!(to > from) || !(upper[i] + upper[i - 1] + lower[i] + lower[i - 1]).allFinite()) continue;
    const int end = clamped_floor(std::ceil(to), clip_left_, clip_right_);
    for (int x = clamped_floor(from, clip_left_, clip_right_); x < end; ++x) {
      const double t = std::clamp((x + 0.5 - from) / (to - from), 0.0, 1.0);
      const double top = std::lerp(upper[i - 1].y(), upper[i].y(), t);
      const double bottom = std::lerp(lower[i - 1].y(), lower[i].y(), t);
      fill(Rect{std::max<double>(x, from), top, std::min(x + 1.0, to), bottom}, color, opacity);
    }
  }
}

void Canvas::disc(const Point& center, double radius, Color color, double opacity) {
  if (!center.allFinite()) return;
  const int bottom = clamped_floor(center.y() + radius + 1.5, clip_top_, clip_bottom_);
  const int right = clamped_floor(center.x() + radius + 1.5, clip_left_, clip_right_);
  for (int y = clamped_floor(center.y() - radius - 0.5, clip_top_, clip_bottom_); y < bottom; ++y) {
    const double dy = y + 0.5 - center.y();
    for (int x = clamped_floor(center.x() - radius - 0.5, clip_left_, clip_right_); x < right;
         ++x) {
      const double dx = x + 0.5 - center.x();
      const double coverage = radius + 0.5 - std::sqrt(dx * dx + dy * dy);
      if (coverage > 0.0) blend(x, y, color, opacity * std::min(1.0, coverage));
    }
  }
}

void Canvas::cover_capsule(const Point& from, const Point& to, double radius) {
  const double reach = radius + 0.5;
  const Point along = to - from;
  const double length2 = std::max(along.squaredNorm(), 1e-12);
  const int bottom =
      clamped_floor(std::ceil(std::max(from.y(), to.y()) + reach), clip_top_, clip_bottom_);
  for (int y = clamped_floor(std::min(from.y(), to.y()) - reach, clip_top_, clip_bottom_);
       y < bottom; ++y) {
    double low = 0.0, high = 1.0;
    if (std::abs(along.y()) > 1e-9) {
      const double a = (y - reach - from.y()) / along.y();
      const double b = (y + 1 + reach - from.y()) / along.y();
      low = std::clamp(std::min(a, b), 0.0, 1.0);
      high = std::clamp(std::max(a, b), 0.0, 1.0);
    }
    const double x_low = from.x() + low * along.x(), x_high = from.x() + high * along.x();
    const int first = clamped_floor(std::min(x_low, x_high) - reach, clip_left_, clip_right_);
    const int last =
        clamped_floor(std::ceil(std::max(x_low, x_high) + reach), clip_left_, clip_right_);
    if (first >= last) continue;
    row_first_[y] = std::min(row_first_[y], first);
    row_last_[y] = std::max(row_last_[y], last - 1);
    float* row = &mask_[static_cast<std::size_t>(y) * width()];
    for (int x = first; x < last; ++x) {
      const Point offset = Point(x + 0.5, y + 0.5) - from;
      const double t = std::clamp(offset.dot(along) / length2, 0.0, 1.0);
      const double coverage = reach - (offset - t * along).norm();
      row[x] = std::max(row[x], static_cast<float>(std::min(1.0, coverage)));
    }
  }
}

void Canvas::cover_dashes(const Point& from, const Point& to, const Stroke& stroke, double& phase) {
  const double length = (to - from).norm();
  const Point direction = (to - from) / std::max(length, 1e-12);
  const double period = stroke.dash + stroke.gap;
  const double start = phase;
  phase = std::fmod(phase + length, period);
  for (double s = -start; s < length; s += period) {
    const double begin = std::max(0.0, s), end = std::min(length, s + stroke.dash);
    if (end > begin) {
      cover_capsule(from + begin * direction, from + end * direction, stroke.width / 2);
    }
  }
}

void Canvas::composite(const Stroke& stroke) {
  const double strength = stroke.opacity * std::min(1.0, stroke.width);
  for (int y = clip_top_; y < clip_bottom_; ++y) {
    float* row = &mask_[static_cast<std::size_t>(y) * width()];
    for (int x = row_first_[y]; x <= row_last_[y]; ++x) {
      if (row[x] > 0.0f) blend(x, y, stroke.color, strength * row[x]);
      row[x] = 0.0f;
    }
    row_first_[y] = width();
    row_last_[y] = -1;
  }
}

void Canvas::line(const Point& from, const Point& to, const Stroke& stroke) {
  const std::array<Point, 2> points = {from, to};
  polyline(points, stroke);
}

void Canvas::polyline(std::span<const Point> points, const Stroke& stroke, bool closed) {
  if (points.empty()) return;
  const std::size_t segments = closed ? points.size() : points.size() - 1;
  const Rect reach = clip_.grown(stroke.width + 2.0);
  Stroke drawn = stroke;
  drawn.width = std::max(1.0, stroke.width);
  double phase = 0.0;
  for (std::size_t i = 0; i < segments; ++i) {
    Point from = points[i], to = points[(i + 1) % points.size()];
    if (!from.allFinite() || !to.allFinite() || !cut_to(reach, from, to)) continue;
    if (stroke.gap > 0.0) {
      cover_dashes(from, to, drawn, phase);
    } else {
      cover_capsule(from, to, drawn.width / 2);
    }
  }
  composite(stroke);
}

Rect Canvas::text_rect(const Point& anchor, std::string_view text, const TextStyle& style) {
  const double length = text_width(text, style.size, style.bold);
  const double before = style.along == Align::kBegin    ? 0.0
                        : style.along == Align::kMiddle ? length / 2
                                                        : length;
  // Above the base line stand capitals of 0.73 em; below it descenders of 0.21 em.
  const double cap = 0.73 * style.size, descender = 0.21 * style.size;
  const double above = style.across == Align::kBegin    ? 0.0
                       : style.across == Align::kMiddle ? cap / 2
                                                        : cap;
  if (style.upward) {
    return {anchor.x() - above, anchor.y() + before - length, anchor.x() - above + cap + descender,
            anchor.y() + before};
  }
  return {anchor.x() - before, anchor.y() - above, anchor.x() - before + length,
          anchor.y() - above + cap + descender};
}

Rect Canvas::text(const Point& anchor, std::string_view text, const TextStyle& style) {
  const Rect rect = text_rect(anchor, text, style);
  const double cap = 0.73 * style.size;
  const Point pen =
      style.upward ? Point(rect.left + cap, rect.bottom) : Point(rect.left, rect.top + cap);
  // The base line sits on the pixel grid: sharp tops and feet.
  const double pen_x = style.upward ? std::round(pen.x()) : pen.x();
  const double pen_y = style.upward ? pen.y() : std::round(pen.y());
  const TextMask mask = render_text(text, style.size, style.bold, style.upward,
                                    pen_x - std::floor(pen_x), pen_y - std::floor(pen_y));
  const int left = static_cast<int>(std::floor(pen_x)) + mask.left;
  const int top = static_cast<int>(std::floor(pen_y)) + mask.top;
  for (int y = std::max(clip_top_, top); y < std::min(clip_bottom_, top + mask.height); ++y) {
    for (int x = std::max(clip_left_, left); x < std::min(clip_right_, left + mask.width); ++x) {
      const std::uint8_t coverage =
          mask.coverage[static_cast<std::size_t>(y - top) * mask.width + (x - left)];
      if (coverage > 0) blend(x, y, style.color, coverage / 255.0);
    }
  }
  return rect;
}

void Canvas::paste(const Image& image, int left, int top) {
  for (int y = std::max(clip_top_, top); y < std::min(clip_bottom_, top + image.height); ++y) {
    for (int x = std::max(clip_left_, left); x < std::min(clip_right_, left + image.width); ++x) {
      blend(x, y, image.at(x - left, y - top), 1.0);
    }
  }
}

}  // namespace arbox::drawing
