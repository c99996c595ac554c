#include "arbox/geometry/internal/sample_set.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <compare>
#include <limits>
#include <numeric>
#include <string>

#include "arbox/base/error.h"
#include "arbox/base/random.h"

namespace arbox::geometry::internal {
namespace {

constexpr std::uint32_t kPurpose = 0x51424f58;
constexpr double kTolerance = 1e-9;
constexpr double kRelativeTolerance = 4e-15;

using Numbers = std::array<double, 10>;

/// The rotation first, so that boxes sorted by these are sorted by rotation.
Numbers numbers_of(const Box& box) {
  const Quaternion& q = box.rotation;
  const double sign = q.w() < 0.0 ? -1.0 : 1.0;
  return {sign * q.w(),   sign * q.x(),   sign * q.y(), sign * q.z(), box.center.x(),
          box.center.y(), box.center.z(), box.size.x(), box.size.y(), box.size.z()};
}

bool same_rotation(const Numbers& a, const Numbers& b) {
  return std::equal(a.begin(), a.begin() + 4, b.begin());
}

double weight_of(const BoxSamples& samples, std::size_t i) {
  return samples.weights.empty() ? 1.0 : samples.weights[i];
}

int cube_side(int count) {
  int side = static_cast<int>(std::cbrt(static_cast<double>(count)));
  while ((side + 1) * (side + 1) * (side + 1) <= count) ++side;
  while (side * side * side > count) --side;
  return side;
}

/// Strictly between 0 and 1.
double unit(std::uint32_t bits) { return (bits + 0.5) * 0x1p-32; }

/// Point `i` of a box in units of its half sizes.
class Placement {
 public:
  explicit Placement(const QuantileOptions& options)
      : side_(options.placement == "uniform" ? 0 : cube_side(options.points_per_box)),
        overshoots_(options.placement == "jittered_grid") {}

  Eigen::Vector3d operator()(int i, const std::array<std::uint32_t, 4>& words) const {
    const Eigen::Vector3d random(unit(words[0]), unit(words[1]), unit(words[2]));
    if (i >= side_ * side_ * side_) return 2.0 * random - Eigen::Vector3d::Ones();
    const Eigen::Vector3d cell(i / (side_ * side_), i / side_ % side_, i % side_);
    if (!overshoots_) return 2.0 / side_ * (cell + random) - Eigen::Vector3d::Ones();
    const Eigen::Vector3d half = Eigen::Vector3d::Constant(0.5);
    return 2.0 / (side_ - 1) * cell - Eigen::Vector3d::Ones() + (random - half) / side_;
  }

 private:
  int side_;
  bool overshoots_;
};

KernelBox kernel_box(const Box& box, double weight, const Eigen::Vector3d& origin) {
  KernelBox result;
  const RotationRows rows = rows_of(box.rotation);
  std::copy(rows.begin(), rows.end(), result.axes);
  const Eigen::Vector3d offset = box.rotation.conjugate() * (box.center - origin);
  const double tolerance = kTolerance + kRelativeTolerance * box.center.cwiseAbs().maxCoeff();
  for (int a = 0; a < 3; ++a) {
    result.offset[a] = offset[a];
    result.half[a] = 0.5 * box.size[a] + tolerance;
  }
  result.weight = weight;
  return result;
}

}  // namespace

void require_valid(const BoxSamples& samples, std::string_view where) {
  const std::string name(where);
  if (samples.boxes.empty()) throw InvalidArgument(name + ": expected at least one box sample");
  geometry::require_valid(samples.boxes, where);
  if (samples.weights.empty()) return;
  if (samples.weights.size() != samples.boxes.size()) {
    throw InvalidArgument(name + ": expected one weight a sample (" +
                          std::to_string(samples.boxes.size()) + "), got " +
                          std::to_string(samples.weights.size()));
  }
  for (std::size_t i = 0; i < samples.weights.size(); ++i) {
    if (samples.weights[i] >= 0.0 && std::isfinite(samples.weights[i])) continue;
    throw InvalidArgument(name + ": weight in row " + std::to_string(i) +
                          " must be finite and at least 0, got " +
                          std::to_string(samples.weights[i]));
  }
  const double total = std::accumulate(samples.weights.begin(), samples.weights.end(), 0.0);
  if (!(total > 0.0 && std::isfinite(total))) {
    throw InvalidArgument(name + ": the weights must sum to a finite number above 0, got " +
                          std::to_string(total));
  }
}

void require_valid(const QuantileOptions& options) {
  const std::string where = "QuantileOptions: ";
  if (options.points_per_box < 0 || options.points_per_box > 1000000) {
    throw InvalidArgument(where + "points_per_box must be between 0 and 1000000, got " +
                          std::to_string(options.points_per_box));
  }
  if (options.placement == "jittered_grid") {
    const int side = cube_side(options.points_per_box);
    if (side >= 2 && side * side * side == options.points_per_box) return;
    throw InvalidArgument(where + "jittered_grid needs a cube of at least 8 points_per_box, got " +
                          std::to_string(options.points_per_box));
  }
  if (options.placement != "uniform" && options.placement != "stratified") {
    throw InvalidArgument(where + "placement must be uniform, stratified or jittered_grid, got '" +
                          options.placement + "'");
  }
}

SampleSet make_sample_set(const BoxSamples& samples) {
  SampleSet set;
  set.origin = samples.boxes.front().center;
  std::vector<Numbers> numbers;
  std::vector<std::size_t> order;
  numbers.reserve(samples.boxes.size());
  for (std::size_t i = 0; i < samples.boxes.size(); ++i) {
    Box box = samples.boxes[i];
    box.rotation.normalize();
    numbers.push_back(numbers_of(box));
    if (weight_of(samples, i) > 0.0) order.push_back(i);
  }
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return numbers[a] < numbers[b]; });
  // What comes first in the input stays first, so that ties go to the first sample.
  std::vector<std::size_t> first_box(samples.boxes.size());
  std::vector<std::size_t> first_rotation(samples.boxes.size());
  for (std::size_t i = 0; i < order.size(); ++i) {
    const bool same = i > 0 && numbers[order[i]] == numbers[order[i - 1]];
    first_box[order[i]] = same ? first_box[order[i - 1]] : order[i];
  }
  for (std::size_t begin = 0, end = 0; begin < order.size(); begin = end) {
    while (end < order.size() && same_rotation(numbers[order[begin]], numbers[order[end]])) ++end;
    const std::size_t first = *std::min_element(order.begin() + begin, order.begin() + end);
    for (std::size_t i = begin; i < end; ++i) first_rotation[order[i]] = first;
  }
  std::vector<std::size_t> place(samples.boxes.size());
  for (std::size_t i = 0; i < samples.boxes.size(); ++i) {
    const double weight = weight_of(samples, i);
    if (!(weight > 0.0)) continue;
    Box box = samples.boxes[i];
    box.rotation.normalize();
    if (first_box[i] == i) {
      place[i] = set.boxes.size();
      set.boxes.push_back(box);
      set.weights.push_back(0.0);
      set.yaw_only = set.yaw_only && is_yaw_only(box);
    }
    set.weights[place[first_box[i]]] += weight;
    if (first_rotation[i] == i) set.rotations.push_back(box.rotation);
  }
  // In the kernel's order, so that a point in every box has occupancy 1 exactly.
  set.total_weight = std::accumulate(set.weights.begin(), set.weights.end(), 0.0);
  return set;
}

PointSet make_points(const BoxSamples& samples, const SampleSet& set,
                     const QuantileOptions& options) {
  PointSet points;
  const int count = options.points_per_box;
  points.reserve(samples.boxes.size() * count + 8 * set.boxes.size());
  const RandomStream stream(options.seed, samples.object, kPurpose);
  const Placement placement(options);
  for (std::size_t i = 0; i < samples.boxes.size(); ++i) {
    if (!(weight_of(samples, i) > 0.0)) continue;
    const Box& box = samples.boxes[i];
    const Eigen::Vector3d center = box.center - set.origin;
    const Eigen::Matrix3d axes =
        box.rotation.normalized().toRotationMatrix() * (0.5 * box.size).asDiagonal();
    for (int j = 0; j < count; ++j) {
      const auto index = static_cast<std::uint32_t>(i) * count + j;
      const Eigen::Vector3d point = center + axes * placement(j, stream.words(index));
      points.push_back(point.x(), point.y(), point.z());
    }
  }
  if (options.corners) {
    for (Box box : set.boxes) {
      box.center -= set.origin;
      for (const Eigen::Vector3d& corner : corners(box)) {
        points.push_back(corner.x(), corner.y(), corner.z());
      }
    }
  }
  points.pad();
  return points;
}

std::vector<double> occupancies(const SampleSet& set, const PointSet& points) {
  std::vector<KernelBox> boxes;
  boxes.reserve(set.boxes.size());
  for (std::size_t i = 0; i < set.boxes.size(); ++i) {
    boxes.push_back(kernel_box(set.boxes[i], set.weights[i], set.origin));
  }
  std::vector<double> result(points.x.size());
  point_kernels(simd_level())
      .occupancy(points.x.data(), points.y.data(), points.z.data(), points.x.size(), boxes.data(),
                 boxes.size(), result.data());
  result.resize(points.count);
  for (double& value : result) value /= set.total_weight;
  return result;
}

}  // namespace arbox::geometry::internal
