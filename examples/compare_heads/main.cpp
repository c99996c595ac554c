// compare_heads SCAN [STEPS]: what do heads of different kinds believe of the same evidence?
// Trains each for seconds on cars of simulated streets, then asks them about cars of unseen
// streets, whose truth is known, and about those that cluster_fit finds in SCAN.
#include <ATen/TensorOperators.h>
#include <ATen/ops/arange.h>
#include <ATen/ops/empty.h>
#include <torch/optim/adam.h>
#include <torch/utils.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <exception>
#include <iomanip>
#include <iostream>
#include <string>
#include <vector>

#include "arbox/base/parallel.h"
#include "arbox/base/random.h"
#include "arbox/detectors/open_detector.h"
#include "arbox/geometry/overlap.h"
#include "arbox/heads/box_tensor.h"
#include "arbox/heads/distribution_boxes.h"
#include "arbox/heads/head_registry.h"
#include "arbox/io/point_cloud_file.h"
#include "arbox/simulation/street_stream.h"

namespace {

using arbox::geometry::Box;
using arbox::geometry::PointCloudView;

constexpr int kFeatures = 18;

/// Cars with a rough region each, as a proposal stage would give, and what is seen there.
struct Cars {
  std::vector<std::array<float, kFeatures>> features;
  std::vector<Box> regions, truth;
};

/// Five quantiles of the coordinates of the points in and around a region, in its axes; how many
/// there are; and from where the sensor looks. False if there are next to none.
bool describe(const PointCloudView& cloud, const Box& region, std::array<float, kFeatures>& out) {
  const Box around{region.center, region.size + Eigen::Vector3d::Constant(0.6), region.rotation};
  const auto turn = region.rotation.conjugate();
  std::array<std::vector<float>, 3> seen;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Eigen::Vector3d point = cloud.position(i).cast<double>();
    if (!arbox::geometry::contains(around, point)) continue;
    const Eigen::Vector3d local = turn * (point - region.center);
    for (int axis = 0; axis < 3; ++axis) seen[axis].push_back(static_cast<float>(local[axis]));
  }
  if (seen[0].size() < 10) return false;
  std::size_t next = 0;
  for (auto& values : seen) {
    std::sort(values.begin(), values.end());
    for (const double share : {0.0, 0.1, 0.5, 0.9, 1.0}) {
      out[next++] =
          values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
    }
  }
  const Eigen::Vector3d sensor = (turn * -region.center).normalized();
  out[next++] = 0.2F * std::log(static_cast<float>(seen[0].size()));
  out[next++] = static_cast<float>(sensor.x());
  out[next++] = static_cast<float>(sensor.y());
  return true;
}

/// A box as a proposal would have it: somewhat off.
Box rough(const Box& box, std::uint64_t object) {
  const arbox::RandomStream random(7, object, 0);
  const Eigen::Vector3d shift(0.3 * random.normal(0), 0.2 * random.normal(1),
                              0.1 * random.normal(2));
  const Eigen::Array3d scale =
      1.0 +
      0.08 *
          Eigen::Array3d(random.normal(3), random.normal(4), random.normal(5)).min(2.0).max(-2.0);
  return arbox::geometry::make_yaw_box(box.center + box.rotation * shift, box.size.array() * scale,
                                       arbox::geometry::yaw(box) + 0.08 * random.normal(6));
}

Cars simulated_cars(std::uint64_t first, std::int64_t streets) {
  std::vector<Cars> each(static_cast<std::size_t>(streets));
  arbox::parallel_for(streets, 1, 0, [&](std::int64_t i, std::int64_t) {
    const auto scan = arbox::simulation::street_scan({}, 1, first + static_cast<std::uint64_t>(i));
    const auto cloud = scan.cloud();
    const auto boxes = scan.boxes(true);
    const auto classes = scan.classes(true);
    Cars& cars = each[static_cast<std::size_t>(i)];
    for (std::size_t n = 0; n < boxes.size(); ++n) {
      const Box region = rough(boxes[n], 1000 * (first + static_cast<std::uint64_t>(i)) + n);
      std::array<float, kFeatures> features{};
      if (classes[n] != "Car" || !describe(cloud.view(), region, features)) continue;
      cars.features.push_back(features);
      cars.regions.push_back(region);
      cars.truth.push_back(boxes[n]);
    }
  });
  Cars all;
  for (const Cars& cars : each) {
    all.features.insert(all.features.end(), cars.features.begin(), cars.features.end());
    all.regions.insert(all.regions.end(), cars.regions.begin(), cars.regions.end());
    all.truth.insert(all.truth.end(), cars.truth.begin(), cars.truth.end());
  }
  return all;
}

arbox::heads::HeadInput input_of(const Cars& cars) {
  const auto count = static_cast<std::int64_t>(cars.regions.size());
  at::Tensor features = at::empty({count, kFeatures});
  for (std::int64_t i = 0; i < count; ++i) {
    std::copy_n(cars.features[static_cast<std::size_t>(i)].begin(), kFeatures,
                features.data_ptr<float>() + i * kFeatures);
  }
  const at::Tensor regions = arbox::heads::to_tensor(cars.regions);
  return {features, {regions.slice(1, 0, 3), regions.slice(1, 6, 10), regions.slice(1, 3, 6)}, {}};
}

void train(arbox::heads::BoxHead& head, const Cars& cars, int steps) {
  const auto input = input_of(cars);
  const at::Tensor truth = arbox::heads::to_tensor(cars.truth);
  torch::optim::Adam optimizer(head.parameters(), torch::optim::AdamOptions(3e-3));
  for (int step = 0; step < steps; ++step) {
    optimizer.zero_grad();
    head.loss(input, truth).per_object.mean().backward();
    optimizer.step();
  }
}

/// Mean IoU of the most likely boxes, mean log density of the truth where the head has one, and
/// how often the box of p = 0.9 holds 95 % of the true one.
void judge(arbox::heads::BoxHead& head, const Cars& cars) {
  const auto belief = head.forward(input_of(cars));
  const auto count = static_cast<std::int64_t>(cars.truth.size());
  const at::Tensor best = belief->mode({.beam_width = 16}).boxes.select(1, 0);
  const double iou =
      arbox::geometry::overlap_pairs(arbox::heads::to_boxes(best), cars.truth).mean();
  const auto drawn =
      arbox::heads::distribution_boxes(*belief, {1, at::arange(count)}, {.confidences = {0.9}});
  double held = 0.0;
  for (std::size_t i = 0; i < cars.truth.size(); ++i) {
    held += arbox::geometry::overlap(drawn.objects[i].confidence_boxes[0].box, cars.truth[i],
                                     {.measure = arbox::geometry::Overlap::kIog}) > 0.95;
  }
  std::cout << "mean IoU " << iou
            << ", truth held by the box of p = 0.9: " << 100 * held / static_cast<double>(count)
            << " %";
  if (belief->measure() == arbox::heads::Measure::kDensity) {
    std::cout << ", log density of the truth "
              << belief->log_density(arbox::heads::to_tensor(cars.truth)).mean().item<double>();
  }
  std::cout << '\n';
}

void tell(arbox::heads::BoxHead& head, const Cars& cars) {
  const auto belief = head.forward(input_of(cars));
  const auto count = static_cast<std::int64_t>(cars.regions.size());
  const auto best = arbox::heads::to_boxes(belief->mode({.beam_width = 16}).boxes.select(1, 0));
  const auto drawn = arbox::heads::distribution_boxes(*belief, {1, at::arange(count)}, {});
  for (std::size_t i = 0; i < best.size(); ++i) {
    std::cout << "  car at " << best[i].center.x() << ' ' << best[i].center.y() << ": length "
              << best[i].size.x() << " m, uncertainty " << *drawn.objects[i].uncertainty << '\n';
  }
}

void run(const std::string& path, int steps) {
  const Cars known = simulated_cars(0, 32), unseen = simulated_cars(1000, 10);
  std::cout << known.truth.size() << " cars to learn from, " << unseen.truth.size()
            << " of unseen streets\n";
  Cars found;
  const auto scan = arbox::io::read_point_cloud(path);
  for (const auto& detection : arbox::detectors::open_detector("cluster_fit")
                                   ->detect(scan.points.view(), {.score = 0.5})
                                   .detections) {
    std::array<float, kFeatures> features{};
    if (detection.label != "Car" || !describe(scan.points.view(), detection.box, features))
      continue;
    found.features.push_back(features);
    found.regions.push_back(detection.box);
  }
  std::cout << found.regions.size() << " cars found in the scan\n" << std::setprecision(3);
  auto registry = arbox::heads::make_head_registry();
  arbox::heads::CodecOptions coding;
  coding.bins = 64;
  coding.half_turn_equivalent = true;
  const auto codec = arbox::heads::make_codec(coding);
  for (const char* name : {"autoregressive", "discrete", "gaussian", "pointwise"}) {
    torch::manual_seed(1);
    const auto head =
        arbox::heads::make_head(name, {"hidden=[64, 64]"},
                                {.features = kFeatures, .condition = 0, .codec = codec}, registry);
    train(*head, known, steps);
    head->eval();
    std::cout << name << ": ";
    judge(*head, unseen);
    tell(*head, found);
  }
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) {
    std::cerr << "usage: compare_heads SCAN [STEPS]\n";
    return 2;
  }
  try {
    run(argv[1], argc > 2 ? std::stoi(argv[2]) : 300);
  } catch (const std::exception& error) {
    std::cerr << "compare_heads: " << error.what() << '\n';
    return 1;
  }
  return 0;
}
