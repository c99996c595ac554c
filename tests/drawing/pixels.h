#pragma once

#include "arbox/drawing/image.h"

namespace arbox::drawing {

inline bool close(Color a, Color b, int tolerance) {
  const auto near = [&](int u, int v) { return u - v <= tolerance && v - u <= tolerance; };
  return near(a.r, b.r) && near(a.g, b.g) && near(a.b, b.b);
}

/// Pixels of [left, right) x [top, bottom) whose colour is within `tolerance` of the one given.
inline int count_color(const Image& image, Color color, int left, int top, int right, int bottom,
                       int tolerance = 0) {
  int count = 0;
  for (int y = top; y < bottom; ++y) {
    for (int x = left; x < right; ++x) count += close(image.at(x, y), color, tolerance);
  }
  return count;
}

inline int count_color(const Image& image, Color color, int tolerance = 0) {
  return count_color(image, color, 0, 0, image.width, image.height, tolerance);
}

}  // namespace arbox::drawing
