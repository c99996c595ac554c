#include "geometry/overlap_pairs.h"

#include <cmath>
#include <numbers>

#include "arbox/geometry/rotation.h"

namespace arbox::testing {
namespace {

using Eigen::Vector3d;
using geometry::Box;
using geometry::Quaternion;

constexpr double kPi = std::numbers::pi;

// Draws from 20 on, so that they are apart from random_box().
double draw(const RandomStream& stream, int index, double low = 0.0, double high = 1.0) {
  return stream.uniform(20 + index, low, high);
}

int choice(const RandomStream& stream, int index, int count) {
  return static_cast<int>(stream.below(20 + index, count));
}

Quaternion turn(double angle, const Vector3d& axis) {
  return Quaternion(Eigen::Quaterniond(Eigen::AngleAxisd(angle, axis.normalized())));
}

// `box` moved along its own axes by a share of its size each.
Box shifted(Box box, const Vector3d& share) {
  box.center += box.rotation * box.size.cwiseProduct(share);
  return box;
}

Vector3d unit_axis(int axis, double length = 1.0) { return length * Vector3d::Unit(axis); }

double power_of_ten(const RandomStream& stream, int index, double low, double high) {
  return std::pow(10.0, draw(stream, index, low, high));
}

using Maker = std::function<BoxPair(const Box&, const RandomStream&)>;

// The family once with yaw boxes and once with free ones, at random.
PairFamily of_any_box(std::string name, Maker make) {
  return {std::move(name), [make](const RandomStream& stream) {
            return make(random_box(stream, stream.below(10, 2) == 1), stream);
          }};
}

BoxPair touching_faces(const Box& box, const RandomStream& stream) {
  const int axis = choice(stream, 0, 3);
  Vector3d share = unit_axis(axis);
  if (choice(stream, 1, 2)) share[(axis + 1) % 3] = draw(stream, 2, -1.0, 1.0);
  return {box, shifted(box, share)};
}

BoxPair nested_sharing(const Box& box, const RandomStream& stream) {
  Box inner = box;
  Vector3d share = Vector3d::Zero();
  for (int axis = 0; axis < 3; ++axis) {
    const double scale = draw(stream, axis, 0.1, 1.0);
    inner.size[axis] *= scale;
    if (choice(stream, 3 + axis, 2)) share[axis] = 0.5 * (1.0 - scale);
  }
  inner.center += box.rotation * box.size.cwiseProduct(share);
  return {box, inner};
}

BoxPair nearly_coplanar(const Box& box, const RandomStream& stream) {
  Box other = box;
  const double tiny = power_of_ten(stream, 0, -16.0, -6.0);
  const Vector3d axis(draw(stream, 1, -1, 1), draw(stream, 2, -1, 1), draw(stream, 3, -1, 1));
  other.rotation = (box.rotation * turn(tiny, axis)).normalized();
  other.center += tiny * Vector3d(draw(stream, 4), draw(stream, 5), draw(stream, 6));
  if (choice(stream, 7, 2)) other.size *= 1.0 + tiny;
  return {box, choice(stream, 8, 2) ? other : shifted(other, unit_axis(choice(stream, 9, 3), 0.5))};
}

BoxPair edge_to_edge(const Box& box, const RandomStream& stream) {
  const int axis = choice(stream, 0, 3);
  Box other = box;
  other.rotation = box.rotation * turn(draw(stream, 1, 0.1, 1.4), unit_axis(axis));
  const int u = (axis + 1) % 3, v = (axis + 2) % 3;
  const Vector3d edge =
      box.rotation * (0.5 * (unit_axis(u, box.size[u]) + unit_axis(v, box.size[v])));
  const Vector3d own =
      other.rotation * (0.5 * (unit_axis(u, -other.size[u]) + unit_axis(v, -other.size[v])));
  other.center = box.center + edge - own;
  return {box, other};
}

BoxPair corner_on_face(const Box& box, const RandomStream& stream) {
  const Box other = random_box(RandomStream(stream.bits(90), 0, 0), choice(stream, 0, 2) == 1);
  const Vector3d corner = geometry::corners(other)[choice(stream, 1, 8)];
  const Vector3d on_face =
      shifted(box, {0.5, draw(stream, 2, -0.5, 0.5), draw(stream, 3, -0.5, 0.5)}).center;
  Box moved = other;
  moved.center += on_face - corner;
  return {box, moved};
}

BoxPair quarter_turns(const Box& box, const RandomStream& stream) {
  Box other = box;
  const int axis = choice(stream, 0, 3);
  other.rotation = box.rotation * turn(choice(stream, 1, 8) * kPi / 4, unit_axis(axis));
  if (choice(stream, 2, 2)) other.size = Vector3d::Constant(box.size[axis]);
  if (choice(stream, 3, 2)) other = shifted(other, {0.5, -0.5, 0.0});
  return {box, other};
}

Quaternion other_rotation(const RandomStream& stream) {
  return random_box(RandomStream(stream.bits(91), 0, 0), true).rotation;
}

// Up to a million times as long as thick.
BoxPair sheets(const Box& box, const RandomStream& stream) {
  Box a = box, b = box;
  a.size = {10.0, 8.0, 5.0};
  b.size = {6.0, 9.0, 7.0};
  a.size[choice(stream, 0, 3)] = power_of_ten(stream, 1, -5.0, -2.0);
  b.size[choice(stream, 2, 3)] = power_of_ten(stream, 3, -5.0, 0.0);
  if (choice(stream, 4, 2)) b.rotation = other_rotation(stream);
  b.center += 0.3 * Vector3d(draw(stream, 5), draw(stream, 6), draw(stream, 7));
  return {a, b};
}

BoxPair rods(const Box& box, const RandomStream& stream) {
  Box a = box, b = box;
  a.size = Vector3d::Constant(power_of_ten(stream, 0, -5.0, -1.0));
  b.size = Vector3d::Constant(power_of_ten(stream, 1, -5.0, -1.0));
  a.size[choice(stream, 2, 3)] = 10.0;
  b.size[choice(stream, 3, 3)] = 10.0;
  if (choice(stream, 4, 2)) b.size[choice(stream, 5, 3)] = 10.0;
  if (choice(stream, 6, 2)) b.rotation = other_rotation(stream);
  b.center += 0.5 * a.size.minCoeff() * Vector3d(draw(stream, 7), draw(stream, 8), draw(stream, 9));
  return {a, b};
}

BoxPair nearly_parallel_sheets(const Box& box, const RandomStream& stream) {
  Box a = box;
  a.size = {10.0, 8.0, 1e-4};
  Box b = a;
  const double angle = power_of_ten(stream, 0, -9.0, -3.0);
  b.rotation = (a.rotation * turn(angle, {draw(stream, 1, -1, 1), 1.0, 0.0})).normalized();
  b = shifted(b, {0.1, 0.2, draw(stream, 2, -0.5, 0.5)});
  return {a, b};
}

BoxPair large_and_small(const Box& box, const RandomStream& stream) {
  Box large = box,
      small = random_box(RandomStream(stream.bits(92), 0, 0), choice(stream, 0, 2) == 1);
  large.size =
      Vector3d(draw(stream, 1, 0.5, 1.0), draw(stream, 2, 0.5, 1.0), draw(stream, 3, 0.5, 1.0)) *
      power_of_ten(stream, 4, 3.0, 6.0);
  const Vector3d face =
      shifted(large, {0.5, draw(stream, 5, -0.4, 0.4), draw(stream, 6, -0.4, 0.4)}).center;
  small.center += face;
  return {large, small};
}

BoxPair both_large(const Box& box, const RandomStream& stream) {
  const double scale = power_of_ten(stream, 0, 3.0, 9.0);
  Box a = box, b = random_box(RandomStream(stream.bits(93), 0, 0), choice(stream, 1, 2) == 1);
  for (Box* each : {&a, &b}) {
    each->size *= scale;
    each->center *= scale;
  }
  return {a, b};
}

BoxPair far_away(const Box& box, const RandomStream& stream) {
  Box a = box, b = random_box(RandomStream(stream.bits(94), 0, 0), choice(stream, 0, 2) == 1);
  const Vector3d origin(1e6 + draw(stream, 1), -1e6 + draw(stream, 2), draw(stream, 3, -1e3, 1e3));
  a.center += origin;
  b.center += origin;
  return {a, b};
}

}  // namespace

Box random_box(const RandomStream& stream, bool free_rotation, double spread, double smallest,
               double largest) {
  const Vector3d center(stream.uniform(0, -spread, spread), stream.uniform(1, -spread, spread),
                        stream.uniform(2, -spread, spread));
  const Vector3d size(stream.uniform(3, smallest, largest), stream.uniform(4, smallest, largest),
                      stream.uniform(5, smallest, largest));
  if (!free_rotation) return geometry::make_yaw_box(center, size, stream.uniform(6, -kPi, kPi));
  Quaternion rotation(stream.normal(6), stream.normal(7), stream.normal(8), stream.normal(9));
  return {.center = center, .size = size, .rotation = rotation.normalized()};
}

std::vector<PairFamily> random_families() {
  std::vector<PairFamily> families;
  for (const auto& [name, first_free, second_free] : {std::tuple{"YawAndYaw", false, false},
                                                      {"YawAndFree", false, true},
                                                      {"FreeAndFree", true, true}}) {
    families.push_back(
        {name, [first_free = first_free, second_free = second_free](const RandomStream& stream) {
           return BoxPair{random_box(stream, first_free),
                          random_box(RandomStream(stream.bits(95), 1, 0), second_free)};
         }});
  }
  return families;
}

std::vector<PairFamily> degenerate_families() {
  return {
      of_any_box("Identical",
                 [](const Box& box, const RandomStream&) {
                   return BoxPair{box, box};
                 }),
      of_any_box("Equivalent",
                 [](const Box& box, const RandomStream& stream) {
                   return BoxPair{box, geometry::equivalent_boxes(box)[choice(stream, 0, 24)]};
                 }),
      of_any_box("TouchingFaces", touching_faces),
      of_any_box("Nested",
                 [](const Box& box, const RandomStream& stream) {
                   Box inner =
                       random_box(RandomStream(stream.bits(96), 0, 0), true, 0.01, 0.01, 0.1);
                   inner.center += box.center;
                   return BoxPair{box, inner};
                 }),
      of_any_box("NestedSharingFaces", nested_sharing),
      of_any_box("NearlyCoplanar", nearly_coplanar),
      of_any_box("EdgeToEdge", edge_to_edge),
      of_any_box("CornerOnFace", corner_on_face),
      of_any_box("QuarterTurns", quarter_turns),
      of_any_box("Sheets", sheets),
      of_any_box("Rods", rods),
      of_any_box("NearlyParallelSheets", nearly_parallel_sheets),
      of_any_box("LargeAndSmall", large_and_small),
      of_any_box("BothLarge", both_large),
      of_any_box("FarAway", far_away),
  };
}

}  // namespace arbox::testing
