// Every real PCD must read as PCL's own loader reads it, and PCL must read what Arbox writes.
#include <gtest/gtest.h>
#include <pcl/io/pcd_io.h>
#include <pcl/io/ply_io.h>
#include <pcl/point_types.h>

#include <cmath>

#include "arbox/io/point_cloud_file.h"
#include "support/program.h"

namespace arbox::io {
namespace {

namespace fs = std::filesystem;

std::vector<fs::path> files_below(const fs::path& folder, const std::string& extension) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (entry.path().extension() == extension) files.push_back(entry.path());
  }
  return files;
}

bool same(float a, float b) { return a == b || (std::isnan(a) && std::isnan(b)); }

TEST(RealPcd, EveryFileReadsAsPclReadsIt) {
  ARBOX_REQUIRE_DATA(pcl_folder, "pcl");
  ARBOX_REQUIRE_DATA(bins_folder, "binpicking");
  auto files = files_below(pcl_folder, ".pcd");
  for (const auto& path : files_below(bins_folder, ".pcd")) files.push_back(path);
  ASSERT_GE(files.size(), 9U);
  for (const auto& path : files) {
    pcl::PointCloud<pcl::PointXYZ> expected;
    ASSERT_EQ(pcl::io::loadPCDFile(path.string(), expected), 0);
    const auto file = read_point_cloud(path, {.keep_non_finite = true});
    EXPECT_EQ(file.points_in_file, expected.size()) << path;
    EXPECT_EQ(file.width, expected.width) << path;
    EXPECT_EQ(file.height, expected.height) << path;
    const auto view = file.points.view();
    ASSERT_EQ(view.size(), expected.size());
    std::size_t different = 0, non_finite = 0;
    for (std::size_t i = 0; i < view.size(); ++i) {
      const auto p = view.position(i);
      const auto& q = expected[i];
      if (!same(p.x(), q.x) || !same(p.y(), q.y) || !same(p.z(), q.z)) ++different;
      if (!p.allFinite()) ++non_finite;
    }
    EXPECT_EQ(different, 0U) << path;
    EXPECT_EQ(file.non_finite, non_finite) << path;
    EXPECT_EQ(read_point_cloud(path).points.size(), view.size() - non_finite) << path;
  }
}

TEST(RealPcd, ColorsAreThoseThatPclReads) {
  for (const char* name :
       {"pcl/tutorials/region_growing_tutorial.pcd", "binpicking/mOSD/test/test0.pcd"}) {
    ARBOX_REQUIRE_DATA(path, name);
    pcl::PointCloud<pcl::PointXYZRGBA> expected;
    ASSERT_EQ(pcl::io::loadPCDFile(path.string(), expected), 0);
    const auto file = read_point_cloud(path, {.keep_non_finite = true});
    const auto view = file.points.view();
    const auto *r = view.find("r"), *g = view.find("g"), *b = view.find("b");
    ASSERT_TRUE(r != nullptr && g != nullptr && b != nullptr);
    for (std::size_t i = 0; i < view.size(); i += 97) {
      EXPECT_EQ(std::lround(view.value(*r, i) * 255), expected[i].r);
      EXPECT_EQ(std::lround(view.value(*g, i) * 255), expected[i].g);
      EXPECT_EQ(std::lround(view.value(*b, i) * 255), expected[i].b);
    }
  }
}

TEST(WrittenForPcl, PclReadsEveryEncoding) {
  const arbox::testing::TemporaryDirectory folder;
  geometry::PointCloud points{.channels = {"r", "g", "b"}, .values = {}};
  for (int i = 0; i < 3000; ++i) {
    const auto number = static_cast<float>(i);
    const auto byte = [](int value) { return static_cast<float>(value % 256) / 255.0F; };
    points.values.insert(points.values.end(), {number * 0.25F, -number / 3.0F, std::sqrt(number),
                                               byte(i), byte(i / 3), byte(7 * i)});
  }
  for (const char* encoding : {"ascii", "binary", "binary_compressed"}) {
    const auto path = folder / (std::string(encoding) + ".pcd");
    write_point_cloud(path, points.view(), {.encoding = encoding});
    pcl::PointCloud<pcl::PointXYZRGB> read;
    ASSERT_EQ(pcl::io::loadPCDFile(path.string(), read), 0) << encoding;
    ASSERT_EQ(read.size(), points.size());
    for (std::size_t i = 0; i < read.size(); ++i) {
      const float* row = points.values.data() + 6 * i;
      ASSERT_EQ(read[i].x, row[0]) << encoding;
      ASSERT_EQ(read[i].y, row[1]);
      ASSERT_EQ(read[i].z, row[2]);
      ASSERT_EQ(read[i].r, std::lround(row[3] * 255));
      ASSERT_EQ(read[i].g, std::lround(row[4] * 255));
      ASSERT_EQ(read[i].b, std::lround(row[5] * 255));
    }
  }
  for (const char* encoding : {"ascii", "binary"}) {
    const auto path = folder / (std::string(encoding) + ".ply");
    write_point_cloud(path, points.view(), {.encoding = encoding});
    pcl::PointCloud<pcl::PointXYZRGB> read;
    ASSERT_EQ(pcl::io::loadPLYFile(path.string(), read), 0) << encoding;
    ASSERT_EQ(read.size(), points.size());
    for (std::size_t i = 0; i < read.size(); ++i) {
      ASSERT_FLOAT_EQ(read[i].y, points.values[6 * i + 1]);
      ASSERT_EQ(read[i].b, std::lround(points.values[6 * i + 5] * 255));
    }
  }
}

TEST(WrittenByPcl, ArboxReadsEveryEncoding) {
  const arbox::testing::TemporaryDirectory folder;
  pcl::PointCloud<pcl::PointXYZINormal> points(40, 25);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto number = static_cast<float>(i);
    auto& point = points[i];
    point.x = number / 7.0F;
    point.y = i % 10 == 3 ? std::numeric_limits<float>::quiet_NaN() : -number;
    point.z = std::exp(-number / 100.0F);
    point.intensity = number / 1000.0F;
    point.normal_z = 1.0F;
    point.curvature = 0.5F;
  }
  const auto write = [&](const std::string& name) {
    const std::string path = (folder / name).string();
    pcl::PCDWriter writer;
    if (name == "ascii.pcd") return writer.writeASCII(path, points, 9);
    if (name == "binary.pcd") return writer.writeBinary(path, points);
    if (name == "compressed.pcd") return writer.writeBinaryCompressed(path, points);
    return pcl::io::savePLYFile(path, points, name == "binary.ply");
  };
  for (const char* name :
       {"ascii.pcd", "binary.pcd", "compressed.pcd", "binary.ply", "ascii.ply"}) {
    ASSERT_EQ(write(name), 0) << name;
    const auto file = read_point_cloud(folder / name);
    EXPECT_EQ(file.points_in_file, 1000U) << name;
    EXPECT_EQ(file.non_finite, 100U) << name;
    const auto view = file.points.view();
    ASSERT_EQ(view.size(), 900U);
    const auto *intensity = view.find("intensity"), *normal = view.find("normal_z");
    ASSERT_TRUE(intensity != nullptr && normal != nullptr) << name;
    EXPECT_NEAR(view.position(899).x(), 999 / 7.0F, 1e-3) << name;
    EXPECT_NEAR(view.value(*intensity, 899), 0.999, 1e-6) << name;
    EXPECT_EQ(view.value(*normal, 899), 1.0) << name;
  }
}

}  // namespace
}  // namespace arbox::io
