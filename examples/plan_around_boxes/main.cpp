// plan_around_boxes SCAN [MODEL]: how likely is a point, or the volume that a vehicle sweeps,
// occupied? Each object is a distribution over boxes: its draws tell the probability, and the
// boxes that hold it with probability 0.95 are what to stay clear of.
#include <cmath>
#include <exception>
#include <iostream>
#include <string>
#include <vector>

#include "arbox/detectors/open_detector.h"
#include "arbox/geometry/confidence_box.h"
#include "arbox/geometry/overlap.h"
#include "arbox/geometry/quantile_box.h"
#include "arbox/io/point_cloud_file.h"

namespace {

using arbox::geometry::Box;
using arbox::geometry::Detection;

/// Probability that no object does something, from each object's probability that it does;
/// objects are taken as independent of each other.
double none(const std::vector<double>& probabilities) {
  double product = 1.0;
  for (const double probability : probabilities) product *= 1.0 - probability;
  return product;
}

double point_occupied(const std::vector<Detection>& objects, const Eigen::Vector3d& point) {
  std::vector<double> each;
  for (const Detection& object : objects) {
    each.push_back(arbox::geometry::occupancy(object.samples, point));
  }
  return 1.0 - none(each);
}

/// The share of an object's draws that meet any of the boxes along a path. Draws decide for the
/// whole path at once: places of a path are not independent.
double path_occupied(const Detection& object, const std::vector<Box>& path) {
  const auto overlaps = arbox::geometry::overlap_matrix(
      object.samples, path, {.measure = arbox::geometry::Overlap::kIntersection});
  return static_cast<double>((overlaps.rowwise().maxCoeff().array() > 0.0).count()) /
         static_cast<double>(object.samples.size());
}

double path_occupied(const std::vector<Detection>& objects, const std::vector<Box>& path) {
  std::vector<double> each;
  for (const Detection& object : objects) each.push_back(path_occupied(object, path));
  return 1.0 - none(each);
}

/// The boxes of a vehicle, 4.5 m x 1.9 m x 1.6 m, that drives 12 m along an arc (1/m, to the left)
/// on the ground below a sensor 1.73 m high.
std::vector<Box> drive(double curvature) {
  constexpr double kStep = 0.5, kLength = 12.0;
  std::vector<Box> path;
  for (double s = 0.0; s <= kLength; s += kStep) {
    const double turn = curvature * s;
    const double x = curvature == 0.0 ? s : std::sin(turn) / curvature;
    const double y = curvature == 0.0 ? 0.0 : (1.0 - std::cos(turn)) / curvature;
    path.push_back(arbox::geometry::make_yaw_box({x, y, -0.8}, {4.5, 1.9, 1.6}, turn));
  }
  return path;
}

/// The box of each object that holds it with probability 0.95, as far as its draws are true.
std::vector<Box> safe_boxes(const std::vector<Detection>& objects) {
  std::vector<Box> boxes;
  for (const Detection& object : objects) {
    const std::vector<double> p = {0.95};
    boxes.push_back(arbox::geometry::confidence_boxes({.boxes = object.samples}, p)[0].box);
  }
  return boxes;
}

void run(const std::string& scan, const std::string& model) {
  const auto cloud = arbox::io::read_point_cloud(scan);
  const auto detector = arbox::detectors::open_detector(model);
  const auto objects =
      detector->detect(cloud.points.view(), {.score = 0.3, .samples = true}).detections;
  std::cout << objects.size() << " objects\n";
  for (const Detection& object : objects) {
    const Eigen::Vector3d& center = object.box.center;
    // A point on the box's own side face is about as often inside as outside.
    const Eigen::Vector3d side =
        center + object.box.rotation * Eigen::Vector3d(0, 0.5 * object.box.size.y(), 0);
    std::cout << object.label << " at " << center.x() << ' ' << center.y()
              << ": centre occupied with p = " << point_occupied(objects, center)
              << ", side with p = " << point_occupied(objects, side) << '\n';
  }
  const std::vector<Box> keep_clear = safe_boxes(objects);
  double best = 2.0, best_curvature = 0.0;
  for (int i = -4; i <= 4; ++i) {
    const double curvature = 0.01 * i;
    const std::vector<Box> path = drive(curvature);
    const double occupied = path_occupied(objects, path);
    const bool meets = (arbox::geometry::overlap_matrix(keep_clear, path).array() > 0.0).any();
    std::cout << "path with curvature " << curvature << ": occupied with p = " << occupied
              << (meets ? ", meets" : ", clear of") << " the boxes of p = 0.95\n";
    if (occupied < best) best = occupied, best_curvature = curvature;
  }
  std::cout << "best path: curvature " << best_curvature << ", p = " << best << '\n';
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) {
    std::cerr << "usage: plan_around_boxes SCAN [MODEL]\n";
    return 2;
  }
  try {
    run(argv[1], argc > 2 ? argv[2] : "cluster_fit");
  } catch (const std::exception& error) {
    std::cerr << "plan_around_boxes: " << error.what() << '\n';
    return 1;
  }
  return 0;
}
