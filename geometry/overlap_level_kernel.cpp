#include "arbox/geometry/internal/lanes.h"
#include "arbox/geometry/internal/overlap_kernels.h"

namespace arbox::geometry::ARBOX_SIMD {
namespace {

// Keeps quotients of zero by zero at zero; far below the square of any size allowed (1e-40 m).
constexpr double kTiny = 1e-200;

enum Field { kX, kY, kZ, kHalfX, kHalfY, kHalfZ, kCos, kSin, kFields };

struct Boxes {
  alignas(64) double field[kFields][kLanes];

  Lanes operator[](Field which) const { return load(field[which]); }
};

struct Interval {
  Lanes low, high;
};

// The lanes of `smaller` get the box with the smaller base of each pair.
void gather(const OverlapBox* const* first, const OverlapBox* const* second, std::int64_t count,
            Boxes& larger, Boxes& smaller) {
  for (int lane = 0; lane < kLanes; ++lane) {
    const std::int64_t pair = lane < count ? lane : count - 1;
    const OverlapBox* a = first[pair];
    const OverlapBox* b = second[pair];
    if (a->half[0] * a->half[1] > b->half[0] * b->half[1]) {
      const OverlapBox* swapped = a;
      a = b;
      b = swapped;
    }
    for (int axis = 0; axis < 3; ++axis) {
      smaller.field[kX + axis][lane] = a->center[axis];
      smaller.field[kHalfX + axis][lane] = a->half[axis];
      larger.field[kX + axis][lane] = b->center[axis];
      larger.field[kHalfX + axis][lane] = b->half[axis];
    }
    smaller.field[kCos][lane] = a->rotation[0];
    smaller.field[kSin][lane] = a->rotation[3];
    larger.field[kCos][lane] = b->rotation[0];
    larger.field[kSin][lane] = b->rotation[3];
  }
}

Lanes guarded_inverse(Lanes value) {
  const Lanes tiny = broadcast(kTiny);
  return 1.0 / (value + (value < 0.0 ? -tiny : tiny));
}

// Integral of X dY along the edge from p to q, where inverse = 1 / (qy - py) and pY, qY are the
// clamped py, qy.
Lanes edge_integral(Lanes px, Lanes py, Lanes pY, Lanes qx, Lanes qy, Lanes qY, Lanes inverse,
                    const Interval& x) {
  const Lanes zero = broadcast(0.0), one = broadcast(1.0);
  const Lanes a = px + clamp((pY - py) * inverse, zero, one) * (qx - px);
  const Lanes b = qx - clamp((qy - qY) * inverse, zero, one) * (qx - px);
  const Lanes low = minimum(a, b), high = maximum(a, b);
  const Lanes low_x = clamp(low, x.low, x.high), high_x = clamp(high, x.low, x.high);
  const Lanes beyond = (high - high_x) - (low_x - low);
  const Lanes mean = low_x + high_x + beyond / (high - low + kTiny) * (high_x - low_x);
  return 0.5 * mean * (qY - pY);
}

// Area of the rectangle with half axes u, v around the origin inside x times y.
Lanes rectangle_area(Lanes ux, Lanes uy, Lanes vx, Lanes vy, const Interval& x, const Interval& y) {
  const Lanes ax = ux + vx, ay = uy + vy, bx = vx - ux, by = vy - uy;
  const Lanes a = clamp(ay, y.low, y.high), b = clamp(by, y.low, y.high);
  const Lanes c = clamp(-ay, y.low, y.high), d = clamp(-by, y.low, y.high);
  const Lanes along_u = guarded_inverse(by - ay), along_v = guarded_inverse(-ay - by);
  return edge_integral(ax, ay, a, bx, by, b, along_u, x) +
         edge_integral(bx, by, b, -ax, -ay, c, along_v, x) +
         edge_integral(-ax, -ay, c, -bx, -by, d, -along_u, x) +
         edge_integral(-bx, -by, d, ax, ay, a, -along_v, x);
}

// b is the larger box.
Lanes intersection(const Boxes& b, const Boxes& a) {
  const Lanes dx = a[kX] - b[kX], dy = a[kY] - b[kY], dz = a[kZ] - b[kZ];
  const Lanes px = b[kCos] * dx + b[kSin] * dy, py = b[kCos] * dy - b[kSin] * dx;
  const Lanes cosine = b[kCos] * a[kCos] + b[kSin] * a[kSin];
  const Lanes sine = b[kCos] * a[kSin] - b[kSin] * a[kCos];
  const Lanes ux = a[kHalfX] * cosine, uy = a[kHalfX] * sine;
  const Lanes vx = -a[kHalfY] * sine, vy = a[kHalfY] * cosine;
  const Interval x{-b[kHalfX] - px, b[kHalfX] - px};
  const Interval y{-b[kHalfY] - py, b[kHalfY] - py};
  const Lanes height = minimum(a[kHalfZ], b[kHalfZ] - dz) - maximum(-a[kHalfZ], -b[kHalfZ] - dz);

  const Lanes qx = a[kCos] * dx + a[kSin] * dy, qy = a[kCos] * dy - a[kSin] * dx;
  const Lanes cosine_size = magnitude(cosine), sine_size = magnitude(sine);
  const LaneMask meet =
      (magnitude(px) < b[kHalfX] + magnitude(ux) + magnitude(vx)) &
      (magnitude(py) < b[kHalfY] + magnitude(uy) + magnitude(vy)) &
      (magnitude(qx) < a[kHalfX] + cosine_size * b[kHalfX] + sine_size * b[kHalfY]) &
      (magnitude(qy) < a[kHalfY] + sine_size * b[kHalfX] + cosine_size * b[kHalfY]) &
      (height > 0.0);
  const Lanes volume = rectangle_area(ux, uy, vx, vy, x, y) * height;
  return meet ? volume : broadcast(0.0);
}

}  // namespace

std::int64_t near_bounds(const OverlapBounds& probe, const OverlapBounds& bounds,
                         std::int64_t count, std::int64_t* found) {
  std::int64_t hits = 0;
  std::int64_t i = 0;
  for (; i + kLanes <= count; i += kLanes) {
    const Lanes dx = load(bounds.x + i) - *probe.x, dy = load(bounds.y + i) - *probe.y;
    const Lanes radius = load(bounds.radius + i) + *probe.radius;
    const Lanes dz = magnitude(load(bounds.z + i) - *probe.z);
    unsigned mask =
        bits((dx * dx + dy * dy < radius * radius) & (dz < load(bounds.reach + i) + *probe.reach));
    for (; mask != 0; mask &= mask - 1) found[hits++] = i + __builtin_ctz(mask);
  }
  for (; i < count; ++i) {
    const double dx = bounds.x[i] - *probe.x, dy = bounds.y[i] - *probe.y;
    const double radius = bounds.radius[i] + *probe.radius;
    const bool hit = dx * dx + dy * dy < radius * radius &&
                     __builtin_fabs(bounds.z[i] - *probe.z) < bounds.reach[i] + *probe.reach;
    found[hits] = i;
    hits += hit;
  }
  return hits;
}

void level_intersections(const OverlapBox* const* first, const OverlapBox* const* second,
                         std::int64_t count, double* volumes) {
  for (std::int64_t i = 0; i < count; i += kLanes) {
    Boxes larger, smaller;
    gather(first + i, second + i, count - i, larger, smaller);
    const Lanes volume = intersection(larger, smaller);
    for (int lane = 0; lane < kLanes && i + lane < count; ++lane) volumes[i + lane] = volume[lane];
  }
}

}  // namespace arbox::geometry::ARBOX_SIMD
