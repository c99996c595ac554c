#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <pcl/point_cloud.h>
#include <pcl/point_types.h>
#include <pcl/search/kdtree.h>
#include <pcl/segmentation/extract_clusters.h>

#include <algorithm>

#include "arbox/base/random.h"
#include "arbox/detectors/cluster_fit/internal/clusters.h"

namespace arbox::detectors::internal {
namespace {

using Clusters = std::vector<std::vector<std::uint32_t>>;

Clusters clusters_of_pcl(const std::vector<Eigen::Vector3f>& points, double tolerance,
                         int min_points) {
  const auto cloud = std::make_shared<pcl::PointCloud<pcl::PointXYZ>>();
  for (const auto& p : points) cloud->emplace_back(p.x(), p.y(), p.z());
  pcl::EuclideanClusterExtraction<pcl::PointXYZ> extraction;
  extraction.setClusterTolerance(tolerance);
  extraction.setMinClusterSize(min_points);
  extraction.setSearchMethod(std::make_shared<pcl::search::KdTree<pcl::PointXYZ>>());
  extraction.setInputCloud(cloud);
  std::vector<pcl::PointIndices> found;
  extraction.extract(found);
  Clusters clusters;
  for (const auto& cluster : found) {
    auto& members = clusters.emplace_back(cluster.indices.begin(), cluster.indices.end());
    std::sort(members.begin(), members.end());
  }
  std::sort(clusters.begin(), clusters.end());
  return clusters;
}

std::vector<Eigen::Vector3f> scattered(int count, double extent, std::uint64_t seed) {
  const RandomStream draw(seed, 0, 0);
  std::vector<Eigen::Vector3f> points;
  for (int i = 0; i < count; ++i) {
    Eigen::Vector3f point;
    for (int axis = 0; axis < 3; ++axis) {
      point[axis] = static_cast<float>(draw.uniform(3 * i + axis, -extent, extent));
    }
    points.push_back(point);
  }
  return points;
}

// Near the percolation threshold clusters of all sizes and shapes occur.
TEST(EuclideanClusters, EqualThoseOfPcl) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    for (const double tolerance : {0.3, 0.6, 0.9}) {
      const auto points = scattered(3000, 5.0, seed);
      ASSERT_EQ(euclidean_clusters(points, tolerance, 3), clusters_of_pcl(points, tolerance, 3))
          << "seed " << seed << ", tolerance " << tolerance;
    }
  }
}

TEST(EuclideanClusters, TouchAtTheToleranceAndNotBeyond) {
  const std::vector<Eigen::Vector3f> points = {{0, 0, 0}, {0.5f, 0, 0}, {1.01f, 0, 0}};
  EXPECT_THAT(euclidean_clusters(points, 0.5, 1),
              testing::ElementsAre(testing::ElementsAre(0, 1), testing::ElementsAre(2)));
}

TEST(EuclideanClusters, LeaveOutSmallOnes) {
  const std::vector<Eigen::Vector3f> points = {{0, 0, 0}, {9, 0, 0}, {9.1f, 0, 0}};
  EXPECT_THAT(euclidean_clusters(points, 0.5, 2), testing::ElementsAre(testing::ElementsAre(1, 2)));
  EXPECT_TRUE(euclidean_clusters({}, 0.5, 1).empty());
}

TEST(Thinned, KeepsTheFirstPointOfEachCube) {
  const auto points = scattered(5000, 0.5, 7);
  const auto kept = thinned(points, 0.25);
  EXPECT_EQ(kept.size(), 64u);
  EXPECT_TRUE(std::is_sorted(kept.begin(), kept.end()));
  EXPECT_EQ(kept.front(), 0u);
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    const auto cube = [](const Eigen::Vector3f& p) {
      return (p.array() / 0.25f).floor().cast<int>().eval();
    };
    const auto first = std::find_if(kept.begin(), kept.end(), [&](auto k) {
      return (cube(points[k]) == cube(points[i])).all();
    });
    ASSERT_NE(first, kept.end());
    ASSERT_LE(*first, i);
  }
}

}  // namespace
}  // namespace arbox::detectors::internal
