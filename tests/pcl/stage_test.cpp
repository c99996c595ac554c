#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <pcl/register_point_struct.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "arbox/detectors/cluster_fit/cluster_fit.h"
#include "arbox/detectors/open_detector.h"
#include "arbox/geometry/confidence_box.h"
#include "arbox/io/point_cloud_file.h"
#include "arbox/plugins/pcl/box_detector.h"
#include "arbox/plugins/pcl/box_filter.h"
#include "support/refusal.h"

/// A driver's point with fields that PCL's own types do not have.
struct EIGEN_ALIGN16 DriverPoint {
  std::uint16_t ring;
  PCL_ADD_POINT4D;
  double time;
  float feature[3];
  PCL_MAKE_ALIGNED_OPERATOR_NEW
};
POINT_CLOUD_REGISTER_POINT_STRUCT(DriverPoint,
                                  (std::uint16_t, ring, ring)(float, x, x)(float, y, y)(
                                      float, z, z)(double, time, time)(float[3], feature, feature))

/// Coordinates that do not follow each other.
struct ScatteredPoint {
  float x, y, other, z;
};
POINT_CLOUD_REGISTER_POINT_STRUCT(ScatteredPoint,
                                  (float, x, x)(float, y, y)(float, other, other)(float, z, z))

namespace arbox::testing {
namespace {

using geometry::Box;
using geometry::Detection;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

const geometry::PointCloud& street() {
  static const geometry::PointCloud cloud =
      io::read_point_cloud(ARBOX_EXAMPLES "/data/street.bin").points;
  return cloud;
}

template <class PointT>
typename ::pcl::PointCloud<PointT>::Ptr street_of() {
  auto cloud = ::pcl::make_shared<::pcl::PointCloud<PointT>>();
  const auto view = street().view();
  for (std::size_t i = 0; i < view.size(); ++i) {
    cloud->emplace_back().getVector3fMap() = view.position(i);
  }
  return cloud;
}

const std::vector<Detection>& expected() {
  static const std::vector<Detection> detections =
      detectors::ClusterFit()
          .detect(street().view(), {.quantiles = {0.2}, .score = 0.3})
          .detections;
  return detections;
}

void expect_same(const std::vector<Detection>& found, const std::vector<Detection>& wanted) {
  ASSERT_EQ(found.size(), wanted.size());
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    EXPECT_EQ(found[i].label, wanted[i].label);
    EXPECT_EQ(found[i].score, wanted[i].score);
    EXPECT_EQ(found[i].box.center, wanted[i].box.center);
    ASSERT_EQ(found[i].quantile_boxes.size(), 1u);
    EXPECT_EQ(found[i].quantile_boxes[0].box.size, wanted[i].quantile_boxes[0].box.size);
  }
}

template <class PointT>
class BoxDetector : public ::testing::Test {};
using PointTypes = ::testing::Types<::pcl::PointXYZ, ::pcl::PointXYZI, ::pcl::PointXYZRGB,
                                    ::pcl::PointXYZRGBNormal, DriverPoint>;
TYPED_TEST_SUITE(BoxDetector, PointTypes);

TYPED_TEST(BoxDetector, FindsInEveryPointTypeWhatTheDetectorFinds) {
  pcl::BoxDetector<TypeParam> detector;
  detector.setInputCloud(street_of<TypeParam>());
  detector.setModel("cluster_fit");
  detector.setQuantile(0.2);
  std::vector<Detection> detections;
  detector.detect(detections);
  ASSERT_GE(detections.size(), 8u);
  expect_same(detections, expected());
}

/// Keeps what it was given.
class Witness : public detectors::Detector {
 public:
  detectors::DetectionResult detect(const geometry::PointCloudView& cloud,
                                    const detectors::DetectionRequest& request) const override {
    view = cloud;
    asked = request;
    return {};
  }
  mutable geometry::PointCloudView view;
  mutable detectors::DetectionRequest asked;
};

TEST(BoxDetectorStage, HandsTheCloudOverWithoutACopy) {
  const auto cloud = street_of<::pcl::PointXYZRGBNormal>();
  const auto witness = std::make_shared<Witness>();
  pcl::BoxDetector<::pcl::PointXYZRGBNormal> detector;
  detector.setInputCloud(cloud);
  detector.setDetector(witness);
  detector.setQuantiles({0.1, 0.5});
  detector.setConfidence(0.9);
  detector.setScoreThreshold(0.7);
  detector.setSeed(4);
  detector.setNumberOfThreads(2);
  detector.setKeepSamples(true);
  detector.setKnownSizes({{"Car", {{"van", {5, 2, 2}}}}});
  detector.detect();
  EXPECT_EQ(witness->view.data(), reinterpret_cast<const std::byte*>(cloud->points.data()));
  EXPECT_EQ(witness->view.size(), cloud->size());
  EXPECT_EQ(witness->asked.known_sizes.at("Car").at(0).name, "van");
  EXPECT_THAT(witness->asked.quantiles, ElementsAre(0.1, 0.5));
  EXPECT_THAT(witness->asked.confidences, ElementsAre(0.9));
  EXPECT_EQ(witness->asked.score, 0.7);
  EXPECT_EQ(witness->asked.seed, 4u);
  EXPECT_EQ(witness->asked.threads, 2);
  EXPECT_TRUE(witness->asked.samples);
}

TEST(BoxDetectorStage, ShowsFieldsAsChannels) {
  ::pcl::PointCloud<::pcl::PointXYZRGBNormal> colored;
  auto& point = colored.emplace_back();
  point.x = 1, point.y = 2, point.z = 3;
  point.r = 10, point.g = 20, point.b = 30;
  point.normal_x = 0.25F, point.curvature = 7;
  const auto view = pcl::BoxDetector<::pcl::PointXYZRGBNormal>::view_of(colored);
  const auto value = [](const geometry::PointCloudView& cloud, const char* name) {
    return cloud.find(name) == nullptr ? -1.0 : cloud.value(*cloud.find(name), 0);
  };
  EXPECT_EQ(view.position(0), Eigen::Vector3f(1, 2, 3));
  EXPECT_EQ(value(view, "r"), 10);
  EXPECT_EQ(value(view, "g"), 20);
  EXPECT_EQ(value(view, "b"), 30);
  EXPECT_EQ(value(view, "normal_x"), 0.25);
  EXPECT_EQ(value(view, "curvature"), 7);

  ::pcl::PointCloud<DriverPoint> driven;
  DriverPoint& one = driven.emplace_back();
  one.x = 4, one.y = 5, one.z = 6;
  one.ring = 63, one.time = 0.125;
  one.feature[2] = 9;
  const auto other = pcl::BoxDetector<DriverPoint>::view_of(driven);
  EXPECT_EQ(other.position(0), Eigen::Vector3f(4, 5, 6));
  EXPECT_EQ(value(other, "ring"), 63);
  EXPECT_EQ(value(other, "time"), 0.125);
  EXPECT_EQ(value(other, "feature_2"), 9);
  EXPECT_THAT(refusal([] { pcl::BoxDetector<ScatteredPoint>::view_of({}); }),
              HasSubstr("x, y, z, one float after another"));
}

/// The street as an organised cloud, every third point missing.
::pcl::PointCloud<::pcl::PointXYZI>::Ptr organised_street() {
  const auto full = street_of<::pcl::PointXYZI>();
  auto cloud = ::pcl::make_shared<::pcl::PointCloud<::pcl::PointXYZI>>();
  for (const auto& point : *full) {
    cloud->push_back(point);
    if (cloud->size() % 3 == 1) cloud->emplace_back().x = kNan;
  }
  while (cloud->size() % 64 != 0) cloud->emplace_back().z = kNan;
  cloud->width = static_cast<std::uint32_t>(cloud->size() / 64);
  cloud->height = 64;
  cloud->is_dense = false;
  return cloud;
}

TEST(BoxDetectorStage, TakesOrganisedCloudsWithHoles) {
  const auto cloud = organised_street();
  ASSERT_TRUE(cloud->isOrganized());
  pcl::BoxDetector<::pcl::PointXYZI> detector;
  detector.setInputCloud(cloud);
  detector.setQuantile(0.2);
  std::vector<Detection> detections;
  detector.detect(detections);
  expect_same(detections, expected());
  EXPECT_EQ(detector.getDroppedPoints(),
            static_cast<std::int64_t>(cloud->size() - street().size()));
  std::vector<::pcl::PointIndices> objects;
  detector.segment(objects);
  ASSERT_EQ(objects.size(), detections.size());
  for (std::size_t i = 0; i < objects.size(); ++i) {
    ::pcl::Indices inside;
    for (std::size_t p = 0; p < cloud->size(); ++p) {
      const Eigen::Vector3f point = (*cloud)[p].getVector3fMap();
      if (point.allFinite() && geometry::contains(detections[i].box, point.cast<double>())) {
        inside.push_back(static_cast<::pcl::index_t>(p));
      }
    }
    EXPECT_EQ(objects[i].indices, inside);
    EXPECT_GT(inside.size(), 5u);
  }
}

TEST(BoxDetectorStage, FindsWithATrainedModelInOrganisedCloudsWithHoles) {
  const std::string model = ARBOX_MODELS "/pv_rcnn_compact.arbox";
  const auto cloud = organised_street();
  const auto view = street().view();
  std::size_t next = 0;
  for (auto& point : *cloud) {
    if (::pcl::isFinite(point)) {
      point.intensity = static_cast<float>(view.value(*view.find("intensity"), next++));
    }
  }
  ASSERT_EQ(next, view.size());
  pcl::BoxDetector<::pcl::PointXYZI> detector;
  detector.setInputCloud(cloud);
  detector.setModel(model);
  detector.setQuantile(0.2);
  std::vector<Detection> detections;
  detector.detect(detections);
  ASSERT_GE(detections.size(), 15u);
  expect_same(
      detections,
      detectors::open_detector(model)->detect(view, {.quantiles = {0.2}, .score = 0.3}).detections);
  std::vector<::pcl::PointIndices> objects;
  detector.segment(objects);
  ASSERT_EQ(objects.size(), detections.size());
  EXPECT_GT(objects[0].indices.size(), 50u);
}

TEST(BoxDetectorStage, LooksAtTheIndicesAlone) {
  const auto cloud = street_of<::pcl::PointXYZ>();
  auto left = ::pcl::make_shared<::pcl::Indices>();
  geometry::PointCloud half;
  for (std::size_t i = 0; i < cloud->size(); ++i) {
    if ((*cloud)[i].y < 0) continue;
    left->push_back(static_cast<::pcl::index_t>(i));
    half.values.insert(half.values.end(), {(*cloud)[i].x, (*cloud)[i].y, (*cloud)[i].z});
  }
  pcl::BoxDetector<::pcl::PointXYZ> detector;
  detector.setInputCloud(cloud);
  detector.setIndices(left);
  detector.setQuantile(0.2);
  std::vector<Detection> detections;
  detector.detect(detections);
  expect_same(
      detections,
      detectors::ClusterFit().detect(half.view(), {.quantiles = {0.2}, .score = 0.3}).detections);
  std::vector<::pcl::PointIndices> objects;
  detector.segment(objects);
  for (const auto& object : objects) {
    for (const auto index : object.indices) EXPECT_GE((*cloud)[index].y, 0);
  }
  left->push_back(static_cast<::pcl::index_t>(cloud->size()));
  detector.setIndices(left);
  EXPECT_THAT(refusal([&] { detector.detect(); }), HasSubstr("indices of the"));
  EXPECT_THAT(refusal([&] { detector.segment(objects); }), HasSubstr("indices of the"));
  *left = {-1};
  detector.setIndices(left);
  EXPECT_THAT(refusal([&] { detector.detect(); }), HasSubstr("got -1"));
  left->clear();
  detector.setIndices(left);
  detector.detect(detections);
  EXPECT_THAT(detections, IsEmpty());
}

TEST(BoxDetectorStage, RefusesWhatCannotWork) {
  pcl::BoxDetector<::pcl::PointXYZ> detector;
  EXPECT_THAT(refusal([&] { detector.detect(); }), HasSubstr("setInputCloud"));
  std::vector<::pcl::PointIndices> objects;
  EXPECT_THAT(refusal([&] { detector.segment(objects); }), HasSubstr("setInputCloud"));
  EXPECT_THAT(refusal([&] { detector.setModel("cluster_fix"); }), HasSubstr("cluster_fit"));
  EXPECT_THAT(refusal<IoError>([&] { detector.setModel("no/such.arbox"); }),
              HasSubstr("such.arbox"));
  EXPECT_THAT(refusal<ConfigError>([&] { detector.setModel("cluster_fit", {"tolerance=-1"}); }),
              HasSubstr("tolerance"));
  detector.setInputCloud(::pcl::make_shared<::pcl::PointCloud<::pcl::PointXYZ>>());
  detector.detect();
  EXPECT_THAT(detector.getDetections(), IsEmpty());
  detector.setQuantile(1.5);
  EXPECT_NE(refusal([&] { detector.detect(); }), "no error");
}

TEST(BoxDetectorStage, DrawsWireframes) {
  pcl::BoxDetector<::pcl::PointXYZ> detector;
  detector.setInputCloud(street_of<::pcl::PointXYZ>());
  ::pcl::PolygonMesh mesh;
  detector.getWireframes(mesh);
  EXPECT_EQ(mesh.cloud.width, 0u);
  detector.detect();
  const auto& detections = detector.getDetections();
  detector.getWireframes(mesh);
  ::pcl::PointCloud<::pcl::PointXYZRGB> vertices;
  ::pcl::fromPCLPointCloud2(mesh.cloud, vertices);
  ASSERT_EQ(vertices.size() % detections.size(), 0u);
  const std::size_t each = vertices.size() / detections.size();
  for (std::size_t i = 0; i < detections.size(); ++i) {
    for (const Eigen::Vector3d& corner : geometry::corners(detections[i].box)) {
      double nearest = 1e9;
      for (std::size_t v = i * each; v < (i + 1) * each; ++v) {
        nearest = std::min(nearest, (vertices[v].getVector3fMap().cast<double>() - corner).norm());
      }
      EXPECT_LT(nearest, 0.02 * detections[i].box.size.norm());
    }
  }
  EXPECT_NE(vertices[0].rgba & 0xffffffU, 0u);
  for (const auto& polygon : mesh.polygons) {
    ASSERT_EQ(polygon.vertices.size(), 3u);
    for (const auto vertex : polygon.vertices) {
      EXPECT_LT(static_cast<std::size_t>(vertex), vertices.size());
    }
  }
  EXPECT_EQ(pcl::wireframe(pcl::boxes_of(detections), "Car").polygons.size(), mesh.polygons.size());
}

TEST(BoxFilter, CropsToAndRemovesTheBoxesOfAProbability) {
  const auto cloud = organised_street();
  pcl::BoxDetector<::pcl::PointXYZI> detector;
  detector.setInputCloud(cloud);
  detector.setConfidences({0.5, 0.95});
  std::vector<Detection> detections;
  detector.detect(detections);
  std::array<std::set<::pcl::index_t>, 2> kept;
  for (const double p : {0.5, 0.95}) {
    pcl::BoxFilter<::pcl::PointXYZI> filter(true);
    filter.setInputCloud(cloud);
    filter.setDetections(detections, p);
    ::pcl::Indices inside, outside;
    filter.filter(inside);
    const ::pcl::Indices removed = *filter.getRemovedIndices();
    filter.setNegative(true);
    filter.filter(outside);
    EXPECT_EQ(outside, removed);
    EXPECT_EQ(inside.size() + outside.size(), street().size());
    const auto boxes = filter.getBoxes();
    for (std::size_t i = 0; i < inside.size(); i += 17) {
      EXPECT_TRUE(std::any_of(boxes.begin(), boxes.end(), [&](const Box& box) {
        return geometry::contains(box, (*cloud)[inside[i]].getVector3fMap().cast<double>(), 1e-9);
      }));
    }
    kept[p > 0.9] = {inside.begin(), inside.end()};
  }
  EXPECT_GT(kept[0].size(), 500u);
  EXPECT_GT(kept[1].size(), kept[0].size());

  pcl::BoxFilter<::pcl::PointXYZI> filter(true);
  filter.setInputCloud(cloud);
  filter.setDetections(detections, 0.95);
  filter.setKeepOrganized(true);
  ::pcl::PointCloud<::pcl::PointXYZI> organised;
  filter.filter(organised);
  EXPECT_EQ(organised.height, 64u);
  EXPECT_EQ(std::count_if(organised.begin(), organised.end(),
                          [](const auto& point) { return ::pcl::isFinite(point); }),
            static_cast<std::ptrdiff_t>(kept[1].size()));
}

TEST(BoxFilter, TakesBoxesFromSamplesOrSaysWhatIsMissing) {
  Detection detection;
  EXPECT_THAT(refusal([&] { pcl::confidence_boxes_of(std::vector{detection}, 0.9); }),
              HasSubstr("detection 0 has neither"));
  EXPECT_THAT(refusal([&] { pcl::quantile_boxes_of(std::vector{detection}, 0.9); }),
              HasSubstr("before detect()"));
  EXPECT_THAT(refusal([&] { pcl::confidence_boxes_of({}, 1.0); }), HasSubstr("between 0 and 1"));
  for (int i = 0; i < 10; ++i) {
    detection.samples.push_back({.size = Eigen::Vector3d::Constant(1.0 + 0.1 * i)});
  }
  // Nested cubes: the quantile box of q holds 1 - q of them, the confidence box nearly all of the
  // volume of the last one that counts.
  EXPECT_NEAR(pcl::confidence_boxes_of(std::vector{detection}, 0.75)[0].size.x(),
              1.7 * std::cbrt(geometry::kHeldIog), 1e-3);
  EXPECT_NEAR(pcl::quantile_boxes_of(std::vector{detection}, 0.25)[0].size.x(), 1.7, 1e-6);
  pcl::BoxFilter<DriverPoint> filter;
  auto cloud = ::pcl::make_shared<::pcl::PointCloud<DriverPoint>>();
  for (const float x : {0.0F, 0.6F, 0.9F, kNan}) cloud->emplace_back().x = x;
  for (auto& point : *cloud) point.y = point.z = 0;
  filter.setInputCloud(cloud);
  filter.setDetections({detection}, 0.75);
  ::pcl::Indices inside;
  filter.filter(inside);
  EXPECT_THAT(inside, ElementsAre(0, 1));
  filter.setDetections({detection});
  filter.filter(inside);
  EXPECT_THAT(inside, ElementsAre(0));
  filter.setBoxes({});
  ::pcl::PointCloud<DriverPoint> all;
  filter.setNegative(true);
  filter.filter(all);
  EXPECT_EQ(all.size(), 3u);
}

}  // namespace
}  // namespace arbox::testing
