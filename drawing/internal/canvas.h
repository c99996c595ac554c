#pragma once

#include <Eigen/Core>
#include <span>
#include <string_view>
#include <vector>

#include "arbox/drawing/image.h"

/// \file
/// Anti-aliased drawing on an image. Coordinates are pixels, x right and y down, and (0, 0) is the
/// top left corner of the top left pixel. Non-finite coordinates draw nothing.

namespace arbox::drawing {

using Point = Eigen::Vector2d;

struct Rect {
  double left = 0, top = 0, right = 0, bottom = 0;
  double width() const { return right - left; }
  double height() const { return bottom - top; }
  Point center() const { return {(left + right) / 2, (top + bottom) / 2}; }
  bool overlaps(const Rect& other) const {
    return left < other.right && other.left < right && top < other.bottom && other.top < bottom;
  }
  Rect grown(double by) const { return {left - by, top - by, right + by, bottom + by}; }
};

struct Stroke {
  Color color = {};
  double width = 1.0;
  double opacity = 1.0;
  /// Lengths of a dash and of the gap after it, pixels; a gap of 0 draws a whole line.
  double dash = 0.0, gap = 0.0;
};

enum class Align { kBegin, kMiddle, kEnd };

struct TextStyle {
  double size = 14.0;
  Color color = {};
  bool bold = false;
  /// Which part of the text stands at the anchor, along it and across it (kEnd: base line).
  Align along = Align::kBegin;
  Align across = Align::kEnd;
  /// Turned a quarter counter-clockwise.
  bool upward = false;
};

class Canvas {
 public:
  Canvas(int width, int height, Color background);

  int width() const { return image_.width; }
  int height() const { return image_.height; }

  /// Drawing is limited to this rectangle from now on.
  void clip(const Rect& rect);
  void clip_to_all();
  const Rect& clip_rect() const { return clip_; }

  void fill(const Rect& rect, Color color, double opacity = 1.0);
  /// A convex polygon.
  void fill(std::span<const Point> convex, Color color, double opacity = 1.0);
  /// The area between two lines with the same x, ascending.
  void fill_between(std::span<const Point> upper, std::span<const Point> lower, Color color,
                    double opacity);
  void disc(const Point& center, double radius, Color color, double opacity = 1.0);
  void line(const Point& from, const Point& to, const Stroke& stroke);
  void polyline(std::span<const Point> points, const Stroke& stroke, bool closed = false);
  /// Draws text and returns the rectangle that it covers.
  Rect text(const Point& anchor, std::string_view text, const TextStyle& style);
  /// Where text() would draw.
  static Rect text_rect(const Point& anchor, std::string_view text, const TextStyle& style);
  /// Another image with its top left corner at a pixel.
  void paste(const Image& image, int left, int top);

  Image take() { return std::move(image_); }

 private:
  void blend(int x, int y, Color color, double coverage);
  void cover_capsule(const Point& from, const Point& to, double radius);
  void cover_dashes(const Point& from, const Point& to, const Stroke& stroke, double& phase);
  void composite(const Stroke& stroke);

  Image image_;
  Rect clip_;
  int clip_left_ = 0, clip_top_ = 0, clip_right_ = 0, clip_bottom_ = 0;
  // Coverage of the stroke that is being drawn, and the touched columns of each row.
  std::vector<float> mask_;
  std::vector<int> row_first_, row_last_;
};

}  // namespace arbox::drawing
