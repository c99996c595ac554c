#include "arbox/io/detection_json.h"

#include <gtest/gtest.h>

#include <cmath>

#include "arbox/base/random.h"
#include "arbox/io/file.h"
#include "io/expect_refusal.h"
#include "support/program.h"

namespace {

using arbox::geometry::Box;
using arbox::geometry::Detection;
using arbox::geometry::make_yaw_box;
using arbox::io::format_box_json;
using arbox::io::format_detections_json;
using arbox::io::parse_box_json;
using arbox::io::parse_detections_json;
using arbox::io::ScanDetections;
using arbox::testing::expect_refusal;

constexpr const char* kBox = R"({"center":[1,2,3],"size":[4,5,6],"rotation":[1,0,0,0],"yaw":0})";

Box random_box(std::uint64_t object) {
  const arbox::RandomStream random(3, object, 0);
  Box box;
  for (int axis = 0; axis < 3; ++axis) {
    box.center[axis] = 100 * random.normal(axis);
    box.size[axis] = std::exp(random.normal(3 + axis));
  }
  const bool yaw_only = object % 2 == 0;
  box.rotation = {random.normal(6), yaw_only ? 0.0 : random.normal(7),
                  yaw_only ? 0.0 : random.normal(8), random.normal(9)};
  box.rotation.normalize();
  return box;
}

Detection full_detection(std::uint64_t seed) {
  Detection detection;
  detection.label = "Größe \"7\"\n";
  detection.score = 1.0 / 3.0;
  detection.box = random_box(seed);
  detection.quantile_boxes = {{.q = 0.1, .box = random_box(seed + 1), .fallback = false},
                              {.q = 0.7, .box = random_box(seed + 2), .fallback = true}};
  detection.confidence_boxes = {{.p = 0.9, .box = random_box(seed + 3)}};
  detection.log_density = -1e-300;
  detection.uncertainty = 0.1;
  detection.known_size = {.name = seed % 20 == 0 ? "crate" : "", .size = {0.3, 1.2, 1.0 / 7.0}};
  detection.samples = {random_box(seed + 4), random_box(seed + 5)};
  return detection;
}

void expect_same(const Box& a, const Box& b) {
  EXPECT_EQ(a.center, b.center);
  EXPECT_EQ(a.size, b.size);
  EXPECT_LE((a.rotation.coeffs() - b.rotation.coeffs()).norm(), 2e-16);
}

TEST(DetectionJson, HasExactlyTheFieldsOfTheDocumentedSchema) {
  ScanDetections scan{.source = "a/000008.bin", .detections = {Detection{}}};
  Detection& detection = scan.detections[0];
  detection.label = "Car";
  detection.score = 0.93;
  detection.box = make_yaw_box({1, 2.5, -3}, {4, 2, 1.5}, 0);
  EXPECT_EQ(format_detections_json(scan),
            R"({"source":"a/000008.bin","frame":"lidar","detections":[{"class":"Car","score":0.93,)"
            R"("box":{"center":[1.0,2.5,-3.0],"size":[4.0,2.0,1.5],"rotation":[1.0,0.0,0.0,0.0],)"
            R"("yaw":0.0}}]})");
  detection.quantile_boxes = {{.q = 0.1, .box = detection.box, .fallback = false}};
  detection.confidence_boxes = {{.p = 0.9, .box = detection.box}};
  detection.log_density = 1.5;
  detection.uncertainty = 0.25;
  const std::string box = format_box_json(detection.box);
  const std::string text = format_detections_json(scan);
  EXPECT_NE(text.find(R"(,"log_density":1.5,"quantile_boxes":[{"q":0.1,"box":)" + box +
                      R"(,"fallback":false}],"confidence_boxes":[{"p":0.9,"box":)" + box +
                      R"(}],"uncertainty":0.25}]})"),
            std::string::npos)
      << text;
}

TEST(DetectionJson, YawIsThereOnlyWhereTheRotationIsAboutZ) {
  EXPECT_NE(format_box_json(make_yaw_box({0, 0, 0}, {1, 1, 1}, 2)).find("\"yaw\":2"),
            std::string::npos);
  Box tilted;
  tilted.rotation = Eigen::AngleAxisd(0.1, Eigen::Vector3d::UnitX());
  EXPECT_EQ(format_box_json(tilted).find("yaw"), std::string::npos);
}

TEST(DetectionJson, EveryFieldReadsBackAsItWas) {
  for (const int indent : {-1, 0, 2}) {
    ScanDetections scan{.source = "x.pcd", .frame = "camera"};
    for (std::uint64_t i = 0; i < 50; ++i) scan.detections.push_back(full_detection(10 * i));
    const auto read = parse_detections_json(format_detections_json(scan, indent), "t");
    ASSERT_EQ(read.size(), 1u);
    EXPECT_EQ(read[0].source, scan.source);
    EXPECT_EQ(read[0].frame, scan.frame);
    ASSERT_EQ(read[0].detections.size(), scan.detections.size());
    for (std::size_t i = 0; i < scan.detections.size(); ++i) {
      const Detection& a = scan.detections[i];
      const Detection& b = read[0].detections[i];
      EXPECT_EQ(b.label, a.label);
      EXPECT_EQ(b.score, a.score);
      expect_same(b.box, a.box);
      EXPECT_EQ(b.log_density, a.log_density);
      EXPECT_EQ(b.uncertainty, a.uncertainty);
      ASSERT_TRUE(b.known_size);
      EXPECT_EQ(b.known_size->name, a.known_size->name);
      EXPECT_EQ(b.known_size->size, a.known_size->size);
      ASSERT_EQ(b.quantile_boxes.size(), 2u);
      EXPECT_EQ(b.quantile_boxes[1].q, 0.7);
      EXPECT_TRUE(b.quantile_boxes[1].fallback);
      expect_same(b.quantile_boxes[0].box, a.quantile_boxes[0].box);
      ASSERT_EQ(b.confidence_boxes.size(), 1u);
      EXPECT_EQ(b.confidence_boxes[0].p, 0.9);
      expect_same(b.confidence_boxes[0].box, a.confidence_boxes[0].box);
      ASSERT_EQ(b.samples.size(), 2u);
      expect_same(b.samples[1], a.samples[1]);
    }
  }
}

TEST(DetectionJson, LinesArraysAndSequencesOfObjectsRead) {
  const std::vector<ScanDetections> scans = {{.source = "a", .detections = {full_detection(1)}},
                                             {.source = "b"}};
  const std::string lines = arbox::io::format_detections_jsonl(scans);
  EXPECT_EQ(std::count(lines.begin(), lines.end(), '\n'), 2);
  const std::string array =
      "[" + format_detections_json(scans[0], 2) + ",\n" + format_detections_json(scans[1]) + "]";
  for (const std::string& text :
       {lines, array,
        "\n" + format_detections_json(scans[0], 2) + "\n" + format_detections_json(scans[1])}) {
    const auto read = parse_detections_json(text, "t");
    ASSERT_EQ(read.size(), 2u) << text;
    EXPECT_EQ(read[0].detections.size(), 1u);
    EXPECT_EQ(read[1].source, "b");
  }
  for (const char* text : {"", " \n", "[]"}) {
    EXPECT_TRUE(parse_detections_json(text, "t").empty());
  }
}

TEST(DetectionJson, PrettyTextKeepsABoxesNumbersOnOneLine) {
  ScanDetections scan{.source = "a", .detections = {Detection{}}};
  EXPECT_NE(format_detections_json(scan, 2).find("\n        \"center\": [0.0,0.0,0.0],\n"),
            std::string::npos)
      << format_detections_json(scan, 2);
}

TEST(DetectionJson, BytesThatAreNotUtf8AreReplaced) {
  const auto read = parse_detections_json(format_detections_json({.source = "caf\xe9.bin"}), "t");
  EXPECT_EQ(read[0].source, "caf\xef\xbf\xbd.bin");
}

TEST(DetectionJson, APlainListOfBoxesNeedsNeitherClassNorScore) {
  const auto read = parse_detections_json(
      R"({"detections":[{"box":{"center":[1,2,3],"size":[4,5,6],"yaw":0.5}}]})", "t");
  EXPECT_EQ(read[0].detections[0].score, 1.0);
  EXPECT_NEAR(arbox::geometry::yaw(read[0].detections[0].box), 0.5, 1e-15);
}

TEST(DetectionJson, KeysThatOtherProgramsAddedArePassedOver) {
  const auto read = parse_detections_json(
      std::string(R"({"time":7,"detections":[{"track":[1,2],"box":)") + kBox + "}]}", "t");
  EXPECT_EQ(read[0].detections.size(), 1u);
}

TEST(DetectionJson, BadTextIsRefusedWithFileAndLine) {
  const auto refused = [](const std::string& text, const std::vector<std::string>& parts) {
    expect_refusal([&] { parse_detections_json(text, "b.json"); }, parts);
  };
  refused("{", {"b.json:1", "JSON"});
  refused("{\"detections\":[]}\n{\"detections\":[]}\n{\"detections\":[}\n", {"b.json:3", "JSON"});
  refused("{\n\"source\": \"a\",\n\"detections\": nothing}", {"b.json:3"});
  refused("{\"detections\":[1e999]}", {"b.json:1", "1e999"});
  refused("{\"detections\":[NaN]}", {"b.json:1"});
  refused("7", {"b.json: [0]", "object", "7"});
  refused("{\"source\":\"a\"}", {"[0]", "'detections'"});
  refused("{\"detections\":{}}", {"[0]/detections", "array", "object"});
  refused("{\"detections\":[],\"frame\":3}", {"[0]/frame", "string", "3"});
  refused("{\"detections\":[{}]}", {"[0]/detections/0", "'box'"});
  refused(std::string("{\"detections\":[{\"score\":\"high\",\"box\":") + kBox + "}]}",
          {"detections/0/score", "number", "'high'"});
  refused(std::string(R"({"detections":[{"box":)") + kBox + R"(,"quantile_boxes":[{"q":0.1}]}]})",
          {"detections/0/quantile_boxes/0", "'box'"});
}

TEST(DetectionJson, DeeplyNestedTextIsRefusedWithoutACrash) {
  expect_refusal([] { parse_detections_json(std::string(200000, '['), "t"); }, {"t:1"});
  const std::string closed = std::string(200000, '[') + std::string(200000, ']');
  expect_refusal([&] { parse_detections_json(closed, "t"); }, {"[0]", "object"});
}

TEST(DetectionJson, BadBoxesAreRefusedWithTheirField) {
  EXPECT_NO_THROW(parse_box_json(kBox, "t"));
  const auto refused = [](const std::string& text, const std::vector<std::string>& parts) {
    expect_refusal([&] { parse_box_json(text, "t"); }, parts);
  };
  refused("", {"t", "one box", "0 values"});
  refused(R"({"center":[1,2],"size":[4,5,6],"yaw":0})", {"t/center", "three", "[1,2]"});
  refused(R"({"center":[1,2,"3"],"size":[4,5,6],"yaw":0})", {"t/center/2", "number", "'3'"});
  refused(R"({"center":[1,2,null],"size":[4,5,6],"yaw":0})", {"t/center/2", "number", "null"});
  refused(R"({"center":[1,2,3],"size":[4,0,6],"yaw":0})", {"t/size", "above zero"});
  refused(R"({"center":[1,2,3],"size":[4,-5,6],"yaw":0})", {"t/size", "above zero"});
  refused(R"({"center":[1,2,3],"size":[4,5,6]})", {"'yaw'"});
  refused(R"({"center":[1,2,3],"size":[4,5,6],"rotation":[2,0,0,0]})", {"t/rotation", "unit"});
  refused(R"({"center":[1,2,3],"size":[4,5,6],"rotation":[1,0,0]})", {"t/rotation", "four"});
  refused(R"({"center":[1,2,3],"size":[4,5,6],"rotation":[1,0,0,0],"yaw":1})", {"t/yaw", "1"});
  refused(R"({"center":[1,2,3],"size":[4,5,6],"yaw":0,"heading":0})", {"'heading'"});
}

TEST(DetectionJson, WriterRefusesWhatJsonCannotHold) {
  ScanDetections scan{.source = "a", .detections = {Detection{}}};
  scan.detections[0].log_density = -std::numeric_limits<double>::infinity();
  expect_refusal([&] { format_detections_json(scan); }, {"log_density", "finite"});
  scan.detections[0].log_density.reset();
  scan.detections[0].box.size.x() = 0;
  expect_refusal([&] { format_detections_json(scan); }, {"sizes"});
}

TEST(DetectionJson, FilesReadAndDirectoriesAreRefused) {
  const arbox::testing::TemporaryDirectory folder;
  const auto path = folder / "scan.json";
  arbox::io::write_file(path, format_detections_json({.source = "a"}, 2));
  EXPECT_EQ(arbox::io::read_detections_json(path)[0].source, "a");
  expect_refusal([&] { arbox::io::read_detections_json(folder.path()); }, {"directory"});
}

}  // namespace
