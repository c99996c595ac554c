// pcl_pipeline SCAN [MODEL] [MESH.ply]: a detector as one stage of a PCL pipeline. Thins the scan
// with a voxel grid, finds the road, detects objects, and gives each the clusters of its points.
#include <pcl/filters/voxel_grid.h>
#include <pcl/io/ply_io.h>
#include <pcl/sample_consensus/method_types.h>
#include <pcl/sample_consensus/model_types.h>
#include <pcl/segmentation/extract_clusters.h>
#include <pcl/segmentation/sac_segmentation.h>

#include <exception>
#include <iostream>

#include "arbox/geometry/box.h"
#include "arbox/io/point_cloud_file.h"
#include "arbox/plugins/pcl/box_detector.h"
#include "arbox/plugins/pcl/box_filter.h"

namespace {

using Point = pcl::PointXYZI;
using Cloud = pcl::PointCloud<Point>;

/// A scan of any format that Arbox reads.
Cloud::Ptr read(const std::string& path) {
  const arbox::io::PointCloudFile file = arbox::io::read_point_cloud(path);
  const arbox::geometry::PointCloudView view = file.points.view();
  const arbox::geometry::Channel* intensity = view.find("intensity");
  auto cloud = pcl::make_shared<Cloud>();
  for (std::size_t i = 0; i < view.size(); ++i) {
    Point& point = cloud->emplace_back();
    point.getVector3fMap() = view.position(i);
    if (intensity != nullptr) point.intensity = static_cast<float>(view.value(*intensity, i));
  }
  return cloud;
}

Cloud::Ptr thinned(const Cloud::ConstPtr& cloud) {
  pcl::VoxelGrid<Point> grid;
  grid.setInputCloud(cloud);
  grid.setLeafSize(0.1F, 0.1F, 0.1F);
  auto result = pcl::make_shared<Cloud>();
  grid.filter(*result);
  return result;
}

/// Points that are not on the plane of the road, by their indices.
pcl::IndicesPtr above_road(const Cloud::ConstPtr& cloud) {
  pcl::SACSegmentation<Point> road;
  road.setModelType(pcl::SACMODEL_PERPENDICULAR_PLANE);
  road.setMethodType(pcl::SAC_RANSAC);
  road.setAxis(Eigen::Vector3f::UnitZ());
  road.setEpsAngle(0.1);
  road.setDistanceThreshold(0.2);
  road.setInputCloud(cloud);
  pcl::ModelCoefficients plane;
  pcl::PointIndices on_road;
  road.segment(on_road, plane);
  auto above = pcl::make_shared<pcl::Indices>();
  if (plane.values.size() != 4) return above;
  const Eigen::Vector4f side(plane.values.data());
  for (std::size_t i = 0; i < cloud->size(); ++i) {
    const float height = std::copysign(1.0F, side.z()) *
                         (side.head<3>().dot((*cloud)[i].getVector3fMap()) + side.w());
    if (height > 0.2F) above->push_back(static_cast<pcl::index_t>(i));
  }
  return above;
}

std::vector<pcl::PointIndices> clusters_of(const Cloud::ConstPtr& cloud,
                                           const pcl::PointIndices& object) {
  pcl::EuclideanClusterExtraction<Point> extraction;
  extraction.setInputCloud(cloud);
  extraction.setIndices(pcl::make_shared<pcl::Indices>(object.indices));
  extraction.setClusterTolerance(0.4);
  extraction.setMinClusterSize(5);
  std::vector<pcl::PointIndices> clusters;
  extraction.extract(clusters);
  return clusters;
}

void run(const std::string& scan, const std::string& model, const std::string& mesh_file) {
  const Cloud::Ptr cloud = read(scan);
  const Cloud::Ptr thin = thinned(cloud);
  const pcl::IndicesPtr above = above_road(thin);
  std::cout << cloud->size() << " points, " << thin->size() << " after thinning, " << above->size()
            << " above the road\n";

  // The detector looks for the ground itself, so it gets all points.
  arbox::pcl::BoxDetector<Point> detector;
  detector.setInputCloud(thin);
  detector.setModel(model);
  detector.setKeepSamples(true);
  std::vector<arbox::geometry::Detection> detections;
  detector.detect(detections);

  // An object's points: those above the road in the box that holds it with probability 0.9.
  detector.setIndices(above);
  std::vector<pcl::PointIndices> objects;
  detector.segment(arbox::pcl::confidence_boxes_of(detections, 0.9), objects);
  for (std::size_t i = 0; i < objects.size(); ++i) {
    const Eigen::Vector3d& center = detections[i].box.center;
    std::cout << detections[i].label << ' ' << detections[i].score << " at " << center.x() << ' '
              << center.y() << ": " << objects[i].indices.size() << " points in "
              << clusters_of(thin, objects[i]).size() << " clusters\n";
  }

  arbox::pcl::BoxFilter<Point> filter;
  filter.setInputCloud(thin);
  filter.setDetections(detections, 0.9);
  filter.setNegative(true);
  Cloud background;
  filter.filter(background);
  std::cout << detections.size() << " objects; " << background.size() << " points of background\n";
  if (!mesh_file.empty()) {
    pcl::PolygonMesh mesh;
    detector.getWireframes(mesh);
    pcl::io::savePLYFileBinary(mesh_file, mesh);
  }
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) {
    std::cerr << "usage: pcl_pipeline SCAN [MODEL] [MESH.ply]\n";
    return 2;
  }
  try {
    run(argv[1], argc > 2 ? argv[2] : "cluster_fit", argc > 3 ? argv[3] : "");
  } catch (const std::exception& error) {
    std::cerr << "pcl_pipeline: " << error.what() << '\n';
    return 1;
  }
  return 0;
}
