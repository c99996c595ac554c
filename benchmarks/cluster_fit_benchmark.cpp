#include <benchmark/benchmark.h>
#include <pcl/point_types.h>
#include <pcl/search/kdtree.h>
#include <pcl/segmentation/extract_clusters.h>

#include "arbox/detectors/cluster_fit/internal/stages.h"
#include "support/street_scene.h"

// The stages of cluster_fit on a made street of about as many points as a KITTI scan, two threads;
// the clusters also with PCL, for which the grid stands in.
namespace {

using namespace arbox::detectors;
using namespace arbox::detectors::internal;

constexpr int kThreads = 2;

struct Street {
  arbox::testing::StreetScene scene = arbox::testing::make_street({.azimuth_step = 0.17});
  ClusterFitOptions options = {};
  std::int64_t not_finite = 0;
  Points points = used_points(scene.cloud.view(), options.max_range, kThreads, not_finite);
  GroundSurface ground{points, options.ground, options.max_range, kThreads};
  Points standing = standing_points(points, ground, options, kThreads);
  OcclusionMap occlusion{standing};
  Surroundings surroundings{.ground =
                                [this](double x, double y) {
                                  return ground.height(static_cast<float>(x),
                                                       static_cast<float>(y));
                                },
                            .occlusion = &occlusion};
  std::vector<Points> clusters = clusters_of(standing, options.tolerance, options.min_points);
};

const Street& street() {
  static const Street street;
  return street;
}

void count_points(benchmark::State& state, const Points& points) {
  state.counters["points"] = static_cast<double>(points.size());
}

void ground(benchmark::State& state) {
  const Points& points = street().points;
  const ClusterFitOptions options;
  for (auto _ : state) {
    const GroundSurface found(points, options.ground, options.max_range, kThreads);
    benchmark::DoNotOptimize(standing_points(points, found, options, kThreads));
  }
  count_points(state, points);
}

void clusters(benchmark::State& state) {
  std::size_t found = 0;
  for (auto _ : state) {
    found = clusters_of(street().standing, street().options.tolerance, street().options.min_points)
                .size();
  }
  count_points(state, street().standing);
  state.counters["clusters"] = static_cast<double>(found);
}

void clusters_of_pcl(benchmark::State& state) {
  const auto cloud = std::make_shared<pcl::PointCloud<pcl::PointXYZ>>();
  for (const auto& p : street().standing) cloud->emplace_back(p.x(), p.y(), p.z());
  std::vector<pcl::PointIndices> found;
  for (auto _ : state) {
    found.clear();
    pcl::EuclideanClusterExtraction<pcl::PointXYZ> extraction;
    extraction.setClusterTolerance(street().options.tolerance);
    extraction.setMinClusterSize(street().options.min_points);
    extraction.setSearchMethod(std::make_shared<pcl::search::KdTree<pcl::PointXYZ>>());
    extraction.setInputCloud(cloud);
    extraction.extract(found);
  }
  count_points(state, street().standing);
  state.counters["clusters"] = static_cast<double>(found.size());
}

void fit(benchmark::State& state) {
  std::size_t objects = 0;
  for (auto _ : state) {
    objects =
        fit_clusters(street().clusters, street().options, street().surroundings, kThreads).size();
  }
  state.counters["objects"] = static_cast<double>(objects);
}

void samples(benchmark::State& state) {
  auto objects = fit_clusters(street().clusters, street().options, street().surroundings, kThreads);
  std::erase_if(objects, [](const FittedObject& object) { return object.score < 0.3; });
  for (auto _ : state) {
    for (const FittedObject& object : objects) {
      benchmark::DoNotOptimize(
          sample_boxes(object, street().options.sample_count, 0, street().surroundings));
    }
  }
  state.counters["objects"] = static_cast<double>(objects.size());
}

void whole(benchmark::State& state, const DetectionRequest& request) {
  const ClusterFit detector;
  for (auto _ : state) {
    benchmark::DoNotOptimize(detector.detect(street().scene.cloud.view(), request));
  }
}

#define ARBOX_TIMED(function) BENCHMARK(function)->Unit(benchmark::kMillisecond)->UseRealTime()

ARBOX_TIMED(ground);
ARBOX_TIMED(clusters);
ARBOX_TIMED(clusters_of_pcl);
ARBOX_TIMED(fit);
ARBOX_TIMED(samples);
BENCHMARK_CAPTURE(whole, boxes, DetectionRequest{.score = 0.3, .threads = kThreads})
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();
BENCHMARK_CAPTURE(whole, quantile_boxes,
                  DetectionRequest{.quantiles = {0.1, 0.5}, .score = 0.3, .threads = kThreads})
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();

}  // namespace
