#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "arbox/base/error.h"
#include "arbox/drawing/internal/scene_parts.h"

namespace arbox::drawing {
namespace {

using geometry::Channel;
using geometry::PointCloudView;
using geometry::ScalarType;

constexpr int kMapSteps = 256;

const Channel& require_channel(const PointCloudView& cloud, const char* name) {
  if (const Channel* channel = cloud.find(name)) return *channel;
  std::string has = "x, y, z";
  for (const Channel& channel : cloud.channels()) has += ", " + channel.name;
  throw InvalidArgument(std::string("draw_scene: the cloud has no channel '") + name +
                        "' to colour points by, only " + has + "; colour them by height");
}

// Two quantiles of a sample that keeps sorting cheap.
std::pair<double, double> spread(const std::vector<float>& values, double share) {
  std::vector<float> sample;
  const std::size_t step = std::max<std::size_t>(1, values.size() / 40000);
  for (std::size_t i = 0; i < values.size(); i += step) {
    if (std::isfinite(values[i])) sample.push_back(values[i]);
  }
  if (sample.empty()) return {0.0, 1.0};
  const auto at = [&](double q) {
    const auto nth = sample.begin() + static_cast<std::ptrdiff_t>(q * (sample.size() - 1) + 0.5);
    std::nth_element(sample.begin(), nth, sample.end());
    return static_cast<double>(*nth);
  };
  const double low = at(share), high = at(1.0 - share);
  return {low, high};
}

void map_colors(ScenePoints& points, bool dark) {
  std::array<Color, kMapSteps> map;
  for (int i = 0; i < kMapSteps; ++i) map[i] = map_color(i / (kMapSteps - 1.0), dark);
  std::tie(points.low, points.high) = spread(points.values, 0.01);
  if (!(points.high - points.low > 1e-6)) points.high = points.low + 1.0;
  points.colors.reserve(points.values.size());
  for (const float value : points.values) {
    const double t = (value - points.low) / (points.high - points.low);
    const double step = std::isfinite(t) ? std::clamp(t, 0.0, 1.0) * (kMapSteps - 1) : 0.0;
    points.colors.push_back(map[static_cast<std::size_t>(step + 0.5)]);
  }
}

std::uint8_t color_byte(const PointCloudView& cloud, const Channel& channel, std::size_t i,
                        double scale) {
  const double value = cloud.value(channel, i) * scale;
  return static_cast<std::uint8_t>(std::isfinite(value) ? std::clamp(value, 0.0, 255.0) + 0.5 : 0);
}

// Colours are 0..1 as floats, but files with float 0..255 exist.
double rgb_scale(const PointCloudView& cloud, const std::array<Channel, 3>& rgb) {
  for (const Channel& channel : rgb) {
    if (channel.type != ScalarType::kFloat32 && channel.type != ScalarType::kFloat64) return 1.0;
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      if (cloud.value(channel, i) > 1.0) return 1.0;
    }
  }
  return 255.0;
}

// Corners of the box that leaves that share of the points out at either side of each axis.
std::pair<Eigen::Vector3d, Eigen::Vector3d> extent(const ScenePoints& points, double share) {
  Eigen::Vector3d low, high;
  std::vector<float> values(points.positions.size());
  for (int axis = 0; axis < 3; ++axis) {
    std::transform(points.positions.begin(), points.positions.end(), values.begin(),
                   [axis](const Eigen::Vector3f& p) { return p[axis]; });
    std::tie(low[axis], high[axis]) = spread(values, share);
  }
  return {low, high};
}

std::vector<std::uint32_t> sorted_by(const std::vector<float>& keys) {
  std::vector<std::uint32_t> order(keys.size());
  std::iota(order.begin(), order.end(), 0u);
  std::stable_sort(order.begin(), order.end(),
                   [&](std::uint32_t a, std::uint32_t b) { return keys[a] < keys[b]; });
  return order;
}

}  // namespace

ScenePoints collect_points(const PointCloudView& cloud, const SceneOptions& options) {
  ScenePoints points;
  if (cloud.empty()) return points;
  const bool by_rgb = options.color == PointColor::kRgb;
  const Channel* intensity =
      options.color == PointColor::kIntensity ? &require_channel(cloud, "intensity") : nullptr;
  std::array<Channel, 3> rgb;
  if (by_rgb) {
    rgb = {require_channel(cloud, "r"), require_channel(cloud, "g"), require_channel(cloud, "b")};
  }
  const double scale = by_rgb ? rgb_scale(cloud, rgb) : 1.0;
  points.positions.reserve(cloud.size());
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Eigen::Vector3f position = cloud.position(i);
    if (!position.allFinite()) continue;
    points.positions.push_back(position);
    if (by_rgb) {
      points.colors.push_back({color_byte(cloud, rgb[0], i, scale),
                               color_byte(cloud, rgb[1], i, scale),
                               color_byte(cloud, rgb[2], i, scale)});
    } else {
      points.values.push_back(intensity ? static_cast<float>(cloud.value(*intensity, i))
                                        : position.z());
    }
  }
  if (by_rgb || points.positions.empty()) return points;
  points.quantity = intensity ? "intensity" : "height, m";
  map_colors(points, options.background == Background::kDark);
  return points;
}

Region find_region(const ScenePoints& points, const Scene& scene, const SceneOptions& options) {
  Eigen::Vector3d low(-10, -10, -1), high(10, 10, 1);
  if (!points.positions.empty()) std::tie(low, high) = extent(points, 0.003);
  const bool around_origin =
      (low.head<2>().array() <= 0).all() && (high.head<2>().array() >= 0).all();
  Eigen::AlignedBox3d boxes;
  for (const auto* group : {&scene.predictions, &scene.truth}) {
    for (const geometry::Detection& detection : *group) {
      for (const Eigen::Vector3d& corner : geometry::corners(detection.box)) boxes.extend(corner);
    }
  }
  const bool rings = around_origin && (high - low).head<2>().maxCoeff() > 20.0;
  if (rings && !points.positions.empty()) {
    // The outskirts of a scan are sparse.
    std::tie(low, high) = extent(points, boxes.isEmpty() ? 0.06 : 0.02);
  }
  double ground = points.positions.empty() ? 0.0 : extent(points, 0.05).first.z();
  const double reach = (high - low).head<2>().maxCoeff();
  if (!boxes.isEmpty()) {
    if (points.positions.empty()) {
      low = boxes.min();
      high = boxes.max();
      ground = low.z();
    } else if (rings) {
      // A scan reaches far beyond its objects: show these, the sensor and some of what is around.
      const double margin = std::max(4.0, 0.08 * reach);
      for (int axis = 0; axis < 2; ++axis) {
        low[axis] = std::max(low[axis], std::min(-1.5 * margin, boxes.min()[axis] - margin));
        high[axis] = std::min(high[axis], std::max(1.5 * margin, boxes.max()[axis] + margin));
      }
    }
    low = low.cwiseMin(boxes.min());
    high = high.cwiseMax(boxes.max());
  }
  if (options.range > 0.0) {
    low.head<2>().setConstant(-options.range);
    high.head<2>().setConstant(options.range);
  }
  // Tall facades would push the camera away from what stands on the ground.
  const double flat = 0.12 * (high - low).head<2>().maxCoeff();
  if (rings) high.z() = std::min(high.z(), ground + std::max(3.0, flat));
  const Eigen::Vector3d margin = 0.03 * (high - low).cwiseMax(0.5);
  return {low - margin, high + margin, ground, rings};
}

void draw_points_birdseye(Canvas& canvas, const Theme& theme, const ScenePoints& points,
                          const Projection& projection) {
  const Rect& clip = canvas.clip_rect();
  std::vector<Point> pixels;
  std::vector<float> heights;
  std::vector<Color> colors;
  for (std::size_t i = 0; i < points.positions.size(); ++i) {
    const Eigen::Vector3d h = projection.homogeneous(points.positions[i].cast<double>());
    if (h.x() < clip.left || h.x() > clip.right || h.y() < clip.top || h.y() > clip.bottom)
      continue;
    pixels.emplace_back(h.x(), h.y());
    heights.push_back(points.positions[i].z());
    colors.push_back(points.colors[i]);
  }
  if (pixels.empty()) return;
  const double room = std::sqrt(clip.width() * clip.height() / pixels.size());
  const double radius = std::clamp(0.26 * room, 0.55 * theme.unit, 2.2 * theme.unit);
  for (const std::uint32_t i : sorted_by(heights)) canvas.disc(pixels[i], radius, colors[i], 0.9);
}

void draw_points_perspective(Canvas& canvas, const Theme& theme, const ScenePoints& points,
                             const Region& region, const Projection& projection) {
  const Rect& clip = canvas.clip_rect();
  std::vector<Point> pixels;
  std::vector<float> depths;
  std::vector<Color> colors;
  // What stands between the camera and the region would hide it.
  const Eigen::Vector2d around = 0.12 * (region.high - region.low).head<2>();
  const Eigen::AlignedBox2d shown(region.low.head<2>() - around, region.high.head<2>() + around);
  for (std::size_t i = 0; i < points.positions.size(); ++i) {
    const Eigen::Vector3d position = points.positions[i].cast<double>();
    const Eigen::Vector3d h = projection.homogeneous(position);
    if (h.z() < projection.near || !shown.contains(position.head<2>())) continue;
    const Point pixel = h.head<2>() / h.z();
    if (pixel.x() < clip.left || pixel.x() > clip.right || pixel.y() < clip.top ||
        pixel.y() > clip.bottom) {
      continue;
    }
    pixels.push_back(pixel);
    depths.push_back(-static_cast<float>(h.z()));
    colors.push_back(points.colors[i]);
  }
  if (pixels.empty()) return;
  const auto [farthest, nearest] = spread(depths, 0.02);
  const double room = std::sqrt(clip.width() * clip.height() / pixels.size());
  const double middle = std::clamp(0.30 * room, 0.6 * theme.unit, 2.2 * theme.unit);
  for (const std::uint32_t i : sorted_by(depths)) {
    const double relative = -depths[i] / (-0.5 * (farthest + nearest));
    const double radius = std::clamp(middle / relative, 0.5 * middle, 2.0 * middle);
    canvas.disc(pixels[i], radius, colors[i], std::clamp(1.15 - 0.25 * relative, 0.35, 0.95));
  }
}

}  // namespace arbox::drawing
