#include "arbox/io/wireframe.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <sstream>
#include <vector>

#include "arbox/io/point_cloud_file.h"
#include "io/expect_refusal.h"

namespace {

using arbox::geometry::Detection;
using arbox::geometry::make_yaw_box;
using arbox::io::format_wireframes_ply;
using arbox::io::RgbBytes;
using Eigen::Vector3d;

RgbBytes color_of(std::string_view name) {
  return name == "Car" ? RgbBytes{10, 20, 255} : RgbBytes{200, 0, 0};
}

Detection detection(const std::string& label, const arbox::geometry::Box& box) {
  Detection result;
  result.label = label;
  result.box = box;
  return result;
}

struct Mesh {
  std::vector<Vector3d> vertices;
  std::vector<RgbBytes> colors;
  std::vector<std::array<int, 3>> faces;
};

Mesh parse(const std::string& text) {
  std::istringstream stream(text);
  std::string word;
  std::size_t vertices = 0, faces = 0;
  while (stream >> word && word != "end_header") {
    if (word != "element") continue;
    stream >> word >> (word == "vertex" ? vertices : faces);
  }
  Mesh mesh;
  for (std::size_t i = 0; i < vertices; ++i) {
    Vector3d p;
    int r, g, b;
    stream >> p.x() >> p.y() >> p.z() >> r >> g >> b;
    mesh.vertices.push_back(p);
    mesh.colors.push_back(
        {static_cast<std::uint8_t>(r), static_cast<std::uint8_t>(g), static_cast<std::uint8_t>(b)});
  }
  for (std::size_t i = 0; i < faces; ++i) {
    int count = 0;
    std::array<int, 3> face;
    stream >> count >> face[0] >> face[1] >> face[2];
    EXPECT_EQ(count, 3);
    mesh.faces.push_back(face);
  }
  EXPECT_TRUE(stream) << "fewer numbers than the header says";
  EXPECT_FALSE(stream >> word) << "more than the header says";
  return mesh;
}

double signed_volume(const Mesh& mesh) {
  double sum = 0;
  for (const auto& [a, b, c] : mesh.faces) {
    sum += mesh.vertices.at(a).dot(mesh.vertices.at(b).cross(mesh.vertices.at(c))) / 6;
  }
  return sum;
}

TEST(Wireframe, IsAClosedOutwardMeshOfBarsAlongEveryEdge) {
  const auto box = make_yaw_box({10, -5, 1}, {4, 2, 1.5}, 0.7);
  const Mesh mesh = parse(format_wireframes_ply(std::vector{detection("Car", box)}, color_of));
  EXPECT_EQ(mesh.vertices.size(), 13u * 8);
  EXPECT_EQ(mesh.faces.size(), 13u * 12);
  const double w = 0.01 * box.size.norm();
  const double expected = w * w * (4 * (4 + 2 + 1.5 + 3 * w) + 0.75 * 4 + w);
  EXPECT_NEAR(signed_volume(mesh), expected, 1e-3 * expected);
  for (const Vector3d& corner : corners(box)) {
    const auto near = [&](const Vector3d& p) { return (p - corner).norm() < w; };
    EXPECT_EQ(std::count_if(mesh.vertices.begin(), mesh.vertices.end(), near), 3 * 4);
  }
  Vector3d furthest = Vector3d::Constant(-1e9);
  for (const Vector3d& p : mesh.vertices) {
    const Vector3d local = box.rotation.conjugate() * (p - box.center);
    furthest = furthest.cwiseMax(local);
  }
  EXPECT_NEAR(furthest.x(), 3 + 0.5 * w, 1e-5) << "the heading mark looks along +x";
  EXPECT_NEAR(furthest.y(), 1 + 0.5 * w, 1e-5);
}

TEST(Wireframe, ColoursFollowTheClass) {
  const Mesh mesh = parse(
      format_wireframes_ply(std::vector{detection("Car", {}), detection("Van", {})}, color_of));
  EXPECT_EQ(mesh.colors.front(), (RgbBytes{10, 20, 255}));
  EXPECT_EQ(mesh.colors.back(), (RgbBytes{200, 0, 0}));
}

TEST(Wireframe, OtherReadersOpenTheFile) {
  const std::string text = format_wireframes_ply(std::vector{detection("Car", {})}, color_of);
  const auto file = arbox::io::parse_point_cloud(text, "boxes.ply");
  EXPECT_EQ(file.points.size(), 13u * 8);
  EXPECT_EQ(file.points.channels, (std::vector<std::string>{"r", "g", "b"}));
}

TEST(Wireframe, NoDetectionsAreAnEmptyMeshAndBadBoxesAreRefused) {
  EXPECT_TRUE(parse(format_wireframes_ply({}, color_of)).vertices.empty());
  arbox::geometry::Box bad;
  bad.size.z() = 0;
  arbox::testing::expect_refusal(
      [&] { format_wireframes_ply(std::vector{detection("Car", bad)}, color_of); }, {"sizes"});
}

}  // namespace
