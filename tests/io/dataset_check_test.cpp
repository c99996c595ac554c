#include "arbox/io/dataset_check.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <functional>

#include "arbox/base/error.h"
#include "io/made_scene.h"
#include "support/program.h"

namespace arbox {
namespace {

using io::LabeledObject;
using io::LabeledScene;

/// Scenes in memory.
class MadeDataset : public io::DatasetReader {
 public:
  std::vector<LabeledScene> scenes;
  std::string_view layout() const override { return "made"; }
  io::SceneFrame frame() const override { return io::SceneFrame::kLidar; }
  std::vector<std::string> classes() const override { return {}; }
  std::vector<std::string> splits() const override { return {"all"}; }
  std::vector<std::string> names(std::string_view) const override {
    std::vector<std::string> names;
    for (std::size_t i = 0; i < scenes.size(); ++i) names.push_back(std::to_string(i));
    return names;
  }
  LabeledScene load(std::string_view, std::string_view name) const override {
    LabeledScene scene = scenes[std::stoul(std::string(name))];
    if (scene.name == "broken") throw FormatError("broken.bin: made so");
    return scene;
  }
};

const io::DatasetFinding* find(const io::DatasetCheck& check, const std::string& kind) {
  for (const auto& finding : check.findings) {
    if (finding.kind == kind) return &finding;
  }
  return nullptr;
}

const std::vector<std::string> kMistakes = {"half sizes",    "double sizes", "swapped sizes",
                                            "yaw sense",     "degrees",      "frame",
                                            "bottom centre", "unit"};

struct Injection {
  std::string name, expected;
  std::function<void(LabeledObject&)> spoil;
};

std::vector<Injection> injections() {
  const auto yaw_box = [](LabeledObject& object, double yaw) {
    object.box = geometry::make_yaw_box(object.box.center, object.box.size, yaw);
    object.written_yaw = yaw;
  };
  return {{"nothing", "", [](LabeledObject&) {}},
          {"half", "half sizes", [](LabeledObject& object) { object.box.size *= 0.5; }},
          {"double", "double sizes", [](LabeledObject& object) { object.box.size *= 2.0; }},
          {"swapped", "swapped sizes",
           [](LabeledObject& object) { std::swap(object.box.size.x(), object.box.size.y()); }},
          {"sense", "yaw sense",
           [=](LabeledObject& object) { yaw_box(object, -geometry::yaw(object.box)); }},
          {"degrees", "degrees",
           [=](LabeledObject& object) { yaw_box(object, geometry::yaw(object.box) * 180 / M_PI); }},
          {"camera", "frame",
           [](LabeledObject& object) {
             const Eigen::Vector3d c = object.box.center;
             object.box = geometry::make_yaw_box({-c.y(), -c.z(), c.x()}, object.box.size,
                                                 -geometry::yaw(object.box) - M_PI / 2);
           }},
          {"kitti camera", "frame",
           [](LabeledObject& object) {
             const Eigen::Vector3d c = object.box.center;
             object.box =
                 geometry::make_yaw_box({-c.y(), -c.z() + object.box.size.z() / 2, c.x()},
                                        object.box.size, -geometry::yaw(object.box) - M_PI / 2);
           }},
          {"quarter turn", "frame",
           [](LabeledObject& object) {
             const Eigen::Vector3d c = object.box.center;
             object.box = geometry::make_yaw_box({-c.y(), c.x(), c.z()}, object.box.size,
                                                 geometry::yaw(object.box) + M_PI / 2);
           }},
          {"bottom", "bottom centre",
           [](LabeledObject& object) { object.box.center.z() -= object.box.size.z() / 2; }},
          {"millimetres", "unit", [](LabeledObject& object) {
             object.box.center *= 1000;
             object.box.size *= 1000;
           }}};
}

void expect_found(const io::DatasetReader& dataset, const std::string& split,
                  const std::string& label) {
  MadeDataset made;
  std::vector<LabeledScene> scenes;
  for (const std::string& name : dataset.names(split)) scenes.push_back(dataset.load(split, name));
  for (const Injection& injection : injections()) {
    made.scenes = scenes;
    for (LabeledScene& scene : made.scenes) {
      for (LabeledObject& object : scene.objects) injection.spoil(object);
    }
    const auto check = io::check_dataset(made, "all");
    std::string found;
    for (const auto& finding : check.findings) {
      if (std::count(kMistakes.begin(), kMistakes.end(), finding.kind) > 0) {
        found = finding.kind;
        break;
      }
    }
    EXPECT_EQ(found, injection.expected) << label << ", " << injection.name;
  }
}

TEST(DatasetCheck, FindsEachMistakeInKittisScans) {
  ARBOX_REQUIRE_DATA(root, "kitti");
  expect_found(*io::open_dataset(root), "sample", "kitti");
}

TEST(DatasetCheck, RealRoomsHaveNoMistakes) {
  ARBOX_REQUIRE_DATA(root, "sunrgbd/sunrgbd_trainval");
  for (const char* version : {"v1", "v2"}) {
    const auto dataset = io::open_dataset(root, {.sunrgbd_labels = version, .classes = "all"});
    const auto check = io::check_dataset(*dataset, "all");
    for (const auto& kind : kMistakes) EXPECT_EQ(find(check, kind), nullptr) << version << kind;
    EXPECT_EQ(check.scenes, 3u);
  }
}

TEST(DatasetCheck, TellsBrokenEmptyAndPointlessScans) {
  MadeDataset dataset;
  for (int i = 0; i < 4; ++i) {
    dataset.scenes.push_back(testing::made_scene("s", 1 + i, io::SceneFrame::kLidar, {"a", "b"},
                                                 testing::MadeBoxes::kUpright));
  }
  dataset.scenes[1].name = "broken";
  dataset.scenes[2].cloud.values.clear();
  dataset.scenes[2].objects.clear();
  dataset.scenes[2].point_objects.clear();
  dataset.scenes[3].objects[0].box.center.x() += 100;
  dataset.scenes[3].objects[1].label = dataset.scenes[3].objects[2].label;
  dataset.scenes[3].objects[1].box = dataset.scenes[3].objects[2].box;
  std::atomic<int> calls = 0;
  const auto check = io::check_dataset(dataset, "all", 2, [&] { ++calls; });
  EXPECT_EQ(calls, 4);
  EXPECT_EQ(check.scenes, 4u);
  EXPECT_EQ(check.objects, 12u);
  ASSERT_NE(find(check, "broken"), nullptr);
  EXPECT_EQ(find(check, "broken")->examples[0], "broken.bin: made so");
  ASSERT_NE(find(check, "empty scan"), nullptr);
  EXPECT_EQ(find(check, "empty scan")->examples[0], "2");
  ASSERT_NE(find(check, "box without points"), nullptr);
  EXPECT_EQ(find(check, "box without points")->examples[0], "s object 0 (a)");
  ASSERT_NE(find(check, "doubled box"), nullptr);
  EXPECT_EQ(check.classes.at("a").without_points, 1u);
  const auto again = io::check_dataset(dataset, "all", 1);
  EXPECT_EQ(again.findings.size(), check.findings.size());
}

TEST(DatasetCheck, BinsBelowACameraAreNoMistake) {
  // A camera's z points into the bin: the tops of its boxes are what is seen.
  MadeDataset dataset;
  for (int n = 0; n < 4; ++n) {
    LabeledScene scene{.name = "bin", .frame = io::SceneFrame::kCamera};
    for (int b = 0; b < 4; ++b) {
      const geometry::Box box = geometry::make_yaw_box({0.3 * b, 0, 1}, {0.2, 0.1, 0.08}, 0.3 * b);
      scene.objects.push_back({.label = "object", .box = box, .heading = io::Heading::kUnknown});
      for (int i = 0; i < 200; ++i) {
        const Eigen::Vector3d top(i % 20 / 19.0 - 0.5, i / 20 / 9.0 - 0.5, -0.5);
        const Eigen::Vector3f point =
            (box.center + box.rotation * top.cwiseProduct(box.size).eval()).cast<float>();
        scene.cloud.values.insert(scene.cloud.values.end(), point.data(), point.data() + 3);
      }
    }
    dataset.scenes.push_back(scene);
  }
  const auto check = io::check_dataset(dataset, "all");
  EXPECT_EQ(check.objects, 16u);
  EXPECT_TRUE(check.findings.empty()) << check.findings[0].text;
}

}  // namespace
}  // namespace arbox
