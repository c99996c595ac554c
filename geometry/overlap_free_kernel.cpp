#include "arbox/geometry/internal/overlap_kernels.h"

namespace arbox::geometry::ARBOX_SIMD {
namespace {

struct Point {
  double at[3];
};

// A face of four corners gains at most one corner from each of six cuts; one more is scratch.
struct Polygon {
  Point points[11];
  int size;
};

struct Interval {
  double low, high;
};

// Two boxes in the axes of the larger, with the origin in the centre of the smaller.
struct Pair {
  // Columns: half axes of the smaller box.
  double axes[3][3];
  // Half extents of the smaller box along the axes.
  double reach[3];
  // The larger box.
  Interval slab[3];
  // Added and taken away again, rounds a coordinate to a grid on which differences are exact.
  double grid[3];
};

double snapped(double value, double grid) { return (value + grid) - grid; }

// The grid of numbers up to `reach`: 1.5 times the power of two that is two to four times as much.
double grid_of(double reach) {
  constexpr std::uint64_t kExponent = 0x7ff0000000000000u;
  return 6.0 * __builtin_bit_cast(double, __builtin_bit_cast(std::uint64_t, reach) & kExponent);
}

// Which sides of the three slabs a point is beyond: bits 0-2 below, 3-5 above.
unsigned outside_of(const Point& point, const Pair& pair) {
  unsigned code = 0;
  for (int axis = 0; axis < 3; ++axis) {
    code |= static_cast<unsigned>(point.at[axis] < pair.slab[axis].low) << axis;
    code |= static_cast<unsigned>(point.at[axis] > pair.slab[axis].high) << (axis + 3);
  }
  return code;
}

double column_product(const double* matrix, int column, const double* vector) {
  return matrix[column] * vector[0] + matrix[3 + column] * vector[1] +
         matrix[6 + column] * vector[2];
}

// True if one of the nine directions that are square to an edge of each box separates them.
// `turn` is the smaller box's rotation in the larger's axes, `offset` its centre.
bool separated_by_edges(const OverlapBox& larger, const OverlapBox& smaller,
                        const double (&turn)[3][3], const double (&offset)[3]) {
  // Where edges are parallel the direction vanishes, and rounding must not separate.
  constexpr double kSlack = 1e-14;
  double size[3][3];
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) {
      size[row][column] = __builtin_fabs(turn[row][column]) + kSlack;
    }
  }
  bool separated = false;
  for (int i = 0; i < 3; ++i) {
    const int i1 = (i + 1) % 3, i2 = (i + 2) % 3;
    for (int j = 0; j < 3; ++j) {
      const int j1 = (j + 1) % 3, j2 = (j + 2) % 3;
      const double distance = __builtin_fabs(offset[i2] * turn[i1][j] - offset[i1] * turn[i2][j]);
      separated |= distance > larger.half[i1] * size[i2][j] + larger.half[i2] * size[i1][j] +
                                  smaller.half[j1] * size[i][j2] + smaller.half[j2] * size[i][j1];
    }
  }
  return separated;
}

enum class Relation { kApart, kInside, kMixed };

Relation relate(const OverlapBox& larger, const OverlapBox& smaller, Pair& pair) {
  double between[3], offset[3], turn[3][3];
  for (int axis = 0; axis < 3; ++axis) between[axis] = smaller.center[axis] - larger.center[axis];
  bool apart = false, inside = true;
  for (int row = 0; row < 3; ++row) {
    offset[row] = column_product(larger.rotation, row, between);
    double reach = 0.0;
    for (int column = 0; column < 3; ++column) {
      turn[row][column] = larger.rotation[row] * smaller.rotation[column] +
                          larger.rotation[3 + row] * smaller.rotation[3 + column] +
                          larger.rotation[6 + row] * smaller.rotation[6 + column];
      pair.axes[row][column] = turn[row][column] * smaller.half[column];
      reach += __builtin_fabs(pair.axes[row][column]);
    }
    pair.reach[row] = reach;
    pair.grid[row] = grid_of(reach);
    pair.slab[row] = {snapped(-larger.half[row] - offset[row], pair.grid[row]),
                      snapped(larger.half[row] - offset[row], pair.grid[row])};
    apart |= reach <= pair.slab[row].low || -reach >= pair.slab[row].high;
    inside &= reach <= pair.slab[row].high && -reach >= pair.slab[row].low;
  }
  if (apart) return Relation::kApart;
  if (inside) return Relation::kInside;
  for (int column = 0; column < 3; ++column) {
    const double reach = __builtin_fabs(turn[0][column]) * larger.half[0] +
                         __builtin_fabs(turn[1][column]) * larger.half[1] +
                         __builtin_fabs(turn[2][column]) * larger.half[2];
    apart |= __builtin_fabs(column_product(smaller.rotation, column, between)) >=
             smaller.half[column] + reach;
  }
  return apart || separated_by_edges(larger, smaller, turn, offset) ? Relation::kApart
                                                                    : Relation::kMixed;
}

// Keeps the part of `in` above the bound (keep_above) or the rest of it, so that the two parts of a
// polygon never share an area, and cuts an edge at the same point whichever face it is met on.
// Corners stay on the grid, so that every face sees the same solid to the last bit; without that
// the error of a rod would grow with the square of its length over its thickness.
// Points are written before it is known whether they stay, which spares branches that no CPU can
// predict.
void cut(const Polygon& in, int axis, double bound, bool keep_above, const double (&grid)[3],
         Polygon& out) {
  int size = 0;
  const Point* previous = &in.points[in.size - 1];
  double previous_depth = previous->at[axis] - bound;
  for (int i = 0; i < in.size; ++i) {
    const Point* next = &in.points[i];
    const double depth = next->at[axis] - bound;
    const bool above = depth > 0.0, previous_above = previous_depth > 0.0;
    const Point* from = above ? next : previous;
    const Point* to = above ? previous : next;
    const double from_depth = above ? depth : previous_depth;
    const double to_depth = above ? previous_depth : depth;
    const double share = from_depth / (from_depth - to_depth);
    Point& crossing = out.points[size];
    for (int k = 0; k < 3; ++k) {
      crossing.at[k] = snapped(from->at[k] + share * (to->at[k] - from->at[k]), grid[k]);
    }
    crossing.at[axis] = bound;
    size += above != previous_above;
    out.points[size] = *next;
    size += above == keep_above;
    previous = next;
    previous_depth = depth;
  }
  out.size = size;
}

// a * d - b * c without cancellation (Kahan), on which long thin boxes depend.
double determinant(double a, double b, double c, double d) {
#if defined(__FMA__) || !defined(__x86_64__)
  const double product = b * c;
  return __builtin_fma(a, d, -product) - __builtin_fma(b, c, -product);
#else
  // Without a fused multiply-add the products' rounding errors come from halves (Dekker).
  const auto high_half = [](double value) {
    const double scaled = 134217729.0 * value;
    return scaled - (scaled - value);
  };
  const double a1 = high_half(a), b1 = high_half(b), c1 = high_half(c), d1 = high_half(d);
  const double a0 = a - a1, b0 = b - b1, c0 = c - c1, d0 = d - d1;
  const double ad = a * d, bc = b * c;
  const double ad_error = ((a1 * d1 - ad) + a1 * d0 + a0 * d1) + a0 * d0;
  const double bc_error = ((b1 * c1 - bc) + b1 * c0 + b0 * c1) + b0 * c0;
  return (ad - bc) + (ad_error - bc_error);
#endif
}

struct Moments {
  // Signed area in the yz plane, twice, and the integral of x over it, six times.
  double area, first;
};

Moments moments(const Polygon& polygon) {
  Moments result{0.0, 0.0};
  if (polygon.size < 3) return result;
  const Point& o = polygon.points[0];
  for (int i = 1; i + 1 < polygon.size; ++i) {
    const Point& p = polygon.points[i];
    const Point& q = polygon.points[i + 1];
    const double area =
        determinant(p.at[1] - o.at[1], p.at[2] - o.at[2], q.at[1] - o.at[1], q.at[2] - o.at[2]);
    result.area += area;
    result.first += area * (o.at[0] + p.at[0] + q.at[0]);
  }
  return result;
}

// Integral of clamped x over the part of the polygon inside the y and z slabs.
double face_integral(Polygon& polygon, unsigned any_outside, const Pair& pair) {
  Polygon other;
  Polygon* current = &polygon;
  Polygon* next = &other;
  for (int axis = 1; axis < 3; ++axis) {
    for (int side = 0; side < 2; ++side) {
      if (!(any_outside >> (axis + 3 * side) & 1u)) continue;
      const Interval& slab = pair.slab[axis];
      cut(*current, axis, side ? slab.high : slab.low, side == 0, pair.grid, *next);
      if (next->size < 3) return 0.0;
      Polygon* used = current;
      current = next;
      next = used;
    }
  }
  double integral = 0.0;
  for (int side = 0; side < 2; ++side) {
    if (!(any_outside >> (3 * side) & 1u)) continue;
    const double bound = side ? pair.slab[0].high : pair.slab[0].low;
    cut(*current, 0, bound, side == 1, pair.grid, *next);
    integral += 0.5 * bound * moments(*next).area;
    cut(*current, 0, bound, side == 0, pair.grid, *next);
    if (next->size < 3) return integral;
    Polygon* used = current;
    current = next;
    next = used;
  }
  return integral + moments(*current).first / 6.0;
}

double mixed_volume(const Pair& pair) {
  Point corners[8];
  unsigned outside[8];
  for (int i = 0; i < 8; ++i) {
    for (int row = 0; row < 3; ++row) {
      corners[i].at[row] = snapped(((i & 1) ? pair.axes[row][0] : -pair.axes[row][0]) +
                                       ((i & 2) ? pair.axes[row][1] : -pair.axes[row][1]) +
                                       ((i & 4) ? pair.axes[row][2] : -pair.axes[row][2]),
                                   pair.grid[row]);
    }
    outside[i] = outside_of(corners[i], pair);
  }
  // Counter-clockwise seen from outside.
  static constexpr int kFaces[6][4] = {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4},
                                       {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}};
  constexpr unsigned kBeyondYOrZ = 0b110110;
  double volume = 0.0;
  for (const auto& face : kFaces) {
    unsigned any = 0, all = ~0u;
    Polygon polygon;
    polygon.size = 4;
    for (int i = 0; i < 4; ++i) {
      polygon.points[i] = corners[face[i]];
      any |= outside[face[i]];
      all &= outside[face[i]];
    }
    if (all & kBeyondYOrZ) continue;
    volume += face_integral(polygon, any, pair);
  }
  return volume;
}

double intersection(const OverlapBox& first, const OverlapBox& second) {
  const bool first_is_smaller = first.volume <= second.volume;
  const OverlapBox& smaller = first_is_smaller ? first : second;
  const OverlapBox& larger = first_is_smaller ? second : first;
  Pair pair;
  switch (relate(larger, smaller, pair)) {
    case Relation::kApart:
      return 0.0;
    case Relation::kInside:
      return smaller.volume;
    case Relation::kMixed:
      break;
  }
  return mixed_volume(pair);
}

}  // namespace

void free_intersections(const OverlapBox* const* first, const OverlapBox* const* second,
                        std::int64_t count, double* volumes) {
  for (std::int64_t i = 0; i < count; ++i) volumes[i] = intersection(*first[i], *second[i]);
}

}  // namespace arbox::geometry::ARBOX_SIMD
