#include "support/street_scene.h"

#include <cmath>
#include <numbers>

#include "arbox/base/random.h"

namespace arbox::testing {
namespace {

using geometry::Box;
using geometry::make_yaw_box;

/// A part of an object's box, in shares of its sizes: centre from -0.5 to 0.5, size from 0 to 1.
Box part(const Box& whole, const Eigen::Vector3d& center, const Eigen::Vector3d& size) {
  return {.center = whole.center + whole.rotation * center.cwiseProduct(whole.size),
          .size = size.cwiseProduct(whole.size),
          .rotation = whole.rotation};
}

Convex colored(Convex solid, double intensity, double passed = 0.0, double lost = 0.0) {
  solid.intensity = intensity;
  solid.passed = passed;
  solid.lost = lost;
  return solid;
}

class Builder {
 public:
  Builder(const StreetOptions& options, GroundHeight ground)
      : draw_(options.seed, 0, 3), ground_(std::move(ground)) {}

  void object(const std::string& label, double x, double y, double yaw,
              const Eigen::Vector3d& size) {
    geometry::Detection& detection = truth.emplace_back();
    detection.label = label;
    detection.score = 1.0;
    detection.box = make_yaw_box({x, y, ground_(x, y) + 0.5 * size.z()}, size, yaw);
    const auto solids_of =
        label == "Car" ? car_solids : (label == "Cyclist" ? cyclist_solids : pedestrian_solids);
    for (const Convex& solid : solids_of(detection.box)) {
      solids.push_back({solid, static_cast<int>(truth.size()) - 1});
    }
  }

  void car(double x, double y, double yaw) {
    const double stretch = vary(0.08);
    object("Car", x, y, yaw + 0.02 * vary(1.0),
           {3.95 * (1 + stretch), 1.66 * (1 + 0.4 * vary(0.08)), 1.52 * (1 + vary(0.06))});
  }
  void pedestrian(double x, double y, double yaw) {
    object("Pedestrian", x, y, yaw, {0.75 + vary(0.15), 0.62 + vary(0.06), 1.75 + vary(0.1)});
  }
  void cyclist(double x, double y, double yaw) {
    object("Cyclist", x, y, yaw, {1.76 + vary(0.06), 0.6 + vary(0.04), 1.74 + vary(0.06)});
  }
  void block(double x, double y, double yaw, const Eigen::Vector3d& size, double intensity) {
    solids.push_back(
        {colored(tapered_box(make_yaw_box({x, y, ground_(x, y) + 0.5 * size.z() - 0.3}, size, yaw)),
                 intensity)});
  }
  void pole(double x, double y, double radius, double height) {
    solids.push_back(
        {colored(upright_prism({x, y, ground_(x, y) + 0.5 * height}, radius, height), 0.4)});
  }
  void tree(double x, double y) {
    pole(x, y, 0.16, 3.0);
    for (int i = 0; i < 7; ++i) {
      const double radius = 0.7 + 0.3 * vary(1.0);
      solids.push_back({colored(upright_prism({x + 0.9 * vary(1.0), y + 0.9 * vary(1.0),
                                               ground_(x, y) + 3.6 + 0.9 * vary(1.0)},
                                              radius, 1.2, 7),
                                0.25, 0.45, 0.1)});
    }
  }
  void bush(double x, double y) {
    for (int i = 0; i < 6; ++i) {
      solids.push_back({colored(upright_prism({x + 0.8 * vary(1.0), y + 0.4 * vary(1.0),
                                               ground_(x, y) + 0.5 + 0.2 * vary(1.0)},
                                              0.35 + 0.15 * vary(1.0), 1.0, 6),
                                0.22, 0.4, 0.1)});
    }
  }
  /// Even in [-size, size).
  double vary(double size) { return draw_.uniform(next_++, -size, size); }

  std::vector<OwnedConvex> solids;
  std::vector<geometry::Detection> truth;

 private:
  RandomStream draw_;
  std::uint32_t next_ = 0;
  GroundHeight ground_;
};

}  // namespace

std::vector<Convex> car_solids(const Box& box) {
  std::vector<Convex> solids;
  const double length = box.size.x(), width = box.size.y();
  solids.push_back(colored(
      tapered_box(part(box, {0, 0, -0.19}, {1, 1, 0.38}), 0.03 * length, 0.01 * length, 0.02),
      0.15));
  solids.push_back(colored(
      tapered_box(part(box, {0.28, 0, 0.06}, {0.42, 0.96, 0.13}), 0.1 * length, 0, 0.03 * width),
      0.12));
  solids.push_back(colored(tapered_box(part(box, {-0.14, 0, 0.24}, {0.68, 0.94, 0.48}),
                                       0.22 * length, 0.09 * length, 0.09 * width),
                           0.2, 0.12, 0.2));
  solids.push_back(colored(tapered_box(part(box, {-0.14, 0, 0.485}, {0.42, 0.74, 0.03})), 0.2));
  for (double along : {-0.31, 0.31}) {
    solids.push_back(colored(tapered_box(part(box, {along, 0, -0.41}, {0.15, 0.97, 0.18})), 0.08));
  }
  return solids;
}

std::vector<Convex> pedestrian_solids(const Box& box) {
  std::vector<Convex> solids;
  for (double side : {-1.0, 1.0}) {
    solids.push_back(
        colored(tapered_box(part(box, {0.28 * side, 0.14 * side, -0.27}, {0.34, 0.26, 0.46}), 0.0,
                            0.0, 0.02),
                0.3));
    solids.push_back(
        colored(tapered_box(part(box, {-0.2 * side, 0.4 * side, 0.14}, {0.35, 0.18, 0.36})), 0.35));
  }
  solids.push_back(colored(tapered_box(part(box, {0, 0, 0.15}, {0.36, 0.7, 0.4})), 0.4));
  solids.push_back(colored(upright_prism(box.center + Eigen::Vector3d(0, 0, 0.43 * box.size.z()),
                                         0.11, 0.14 * box.size.z()),
                           0.35));
  return solids;
}

std::vector<Convex> cyclist_solids(const Box& box) {
  std::vector<Convex> solids;
  for (double end : {-0.31, 0.31}) {
    solids.push_back(
        colored(tapered_box(part(box, {end, 0, -0.31}, {0.38, 0.08, 0.38})), 0.2, 0.5));
  }
  solids.push_back(colored(tapered_box(part(box, {0, 0, -0.2}, {0.6, 0.1, 0.1})), 0.3));
  solids.push_back(colored(tapered_box(part(box, {0.28, 0, 0.04}, {0.06, 0.95, 0.05})), 0.3));
  solids.push_back(colored(tapered_box(part(box, {-0.04, 0, -0.12}, {0.2, 0.5, 0.4})), 0.35));
  solids.push_back(
      colored(tapered_box(part(box, {-0.02, 0, 0.2}, {0.25, 0.72, 0.32}), -0.15, 0.15), 0.4));
  const Eigen::Vector3d head = box.rotation * Eigen::Vector3d(0.05 * box.size.x(), 0, 0);
  solids.push_back(
      colored(upright_prism(box.center + head + Eigen::Vector3d(0, 0, 0.43 * box.size.z()), 0.11,
                            0.14 * box.size.z()),
              0.35));
  return solids;
}

StreetScene make_street(const StreetOptions& options) {
  const GroundHeight ground = [options](double x, double y) {
    // The slope sets in gently and a kerb of 9 cm bounds the road.
    const double away = std::max(0.0, std::abs(x) - 6.0);
    const double rise = std::copysign(away * away / (away + 6.0), x);
    const double kerb = (y > 7.2 || y < -5.4) && std::abs(x - 27.5) > 4.0 ? 0.09 : 0.0;
    return -options.sensor_height + options.slope_x * rise + options.slope_y * y + kerb;
  };
  Builder street(options, ground);
  const double pi = std::numbers::pi;
  for (double x : {-27.0, -20.5, -8.5, -2.2, 5.4, 11.6, 18.0, 36.0, 42.5}) street.car(x, -4.3, 0.0);
  for (double x : {-31.0, -17.0, -11.0, 3.6, 9.8, 20.2, 35.2, 41.4, 53.0}) street.car(x, 6.1, pi);
  street.car(16.5, 0.1, 0.0);
  street.car(33.0, -0.3, 0.0);
  street.car(-14.0, -0.2, 0.0);
  street.car(13.2, 3.1, pi);
  street.car(27.2, 9.5, -0.5 * pi);
  street.car(29.0, -12.5, 0.5 * pi);
  street.pedestrian(8.5, -7.2, 0.3);
  street.pedestrian(14.6, -6.8, pi);
  street.pedestrian(15.4, -7.5, 3.0);
  street.pedestrian(10.8, 8.6, 0.2);
  street.pedestrian(22.6, 8.3, -0.5 * pi);
  street.pedestrian(23.2, -1.9, 0.5 * pi);
  street.pedestrian(-6.5, 8.4, 0.0);
  street.cyclist(10.6, -2.2, 0.0);
  street.cyclist(24.6, 3.9, pi);
  street.cyclist(-9.5, 2.8, pi);
  for (double x : {-38.0, -12.0, 12.0, 45.0}) {
    street.block(x, 15.5, 0.0, {x > 30 ? 22.0 : 20.0, 9.0, 9.0}, 0.35);
    street.block(x < 30 ? x : x + 3.0, -14.8, 0.0, {20.0, 10.0, 8.0}, 0.33);
  }
  for (double x : {-24.0, -5.0, 7.0, 20.8, 39.0}) {
    street.tree(x, 8.3);
    street.pole(x + 3.1, -6.3, 0.07, 5.0);
  }
  for (double x : {-15.0, 1.5, 17.4, 37.2}) street.bush(x, -8.6);
  for (double x : {34.0, 47.0}) street.bush(x, 9.3);
  return scan(street.solids, std::move(street.truth), ground, options);
}

}  // namespace arbox::testing
