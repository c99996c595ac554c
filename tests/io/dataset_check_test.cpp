#include "arbox/io/dataset_check.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <functional>

#include "arbox/base/error.h"
#include "arbox/base/random.h"
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

/// Points and tilted boxes in `spread` metres around a place, each box of its own class.
LabeledScene random_scene(std::uint32_t number, const Eigen::Vector3d& place, double spread) {
  const RandomStream random(9, number, 0);
  std::uint32_t draw = 0;
  const auto vector = [&](double low, double high) {
    Eigen::Vector3d result;
    for (double& one : result) one = random.uniform(draw++, low, high);
    return result;
  };
  LabeledScene scene{.name = std::to_string(number)};
  for (int i = 0; i < 300; ++i) {
    Eigen::Vector3f point = (place + vector(-spread, spread)).cast<float>();
    if (i % 20 == 0) point[i / 20 % 3] = i % 40 == 0 ? INFINITY : NAN;
    scene.cloud.values.insert(scene.cloud.values.end(), point.data(), point.data() + 3);
  }
  for (int i = 0; i < 6; ++i) {
    const Eigen::Vector3d axis = vector(-1, 1).normalized();
    LabeledObject object{.label = std::to_string(number) + "." + std::to_string(i)};
    object.box = {place + vector(-1.2 * spread, 1.2 * spread), vector(0.01, 0.5) * spread,
                  geometry::Quaternion(Eigen::AngleAxisd(random.uniform(draw++, -3, 3), axis))};
    scene.objects.push_back(object);
  }
  return scene;
}

TEST(DatasetCheck, BoxesWithoutPointsAreThoseThatBruteForceFinds) {
  constexpr double kMargin = 0.03;
  MadeDataset dataset;
  for (std::uint32_t i = 0; i < 1200; ++i) {
    const double spread = std::pow(10.0, i % 5 - 1.0);
    const Eigen::Vector3d place = Eigen::Vector3d(1, -2, 0.1) * (i % 3) * 1000.0;
    dataset.scenes.push_back(random_scene(i, place, spread));
  }
  const auto check = io::check_dataset(dataset, "all");
  std::size_t without = 0;
  for (const LabeledScene& scene : dataset.scenes) {
    for (const LabeledObject& object : scene.objects) {
      const auto inside = io::points_in_boxes(scene.cloud.view(), {object.box}, kMargin);
      const auto& summary = check.classes.at(object.label);
      EXPECT_EQ(summary.without_points, inside[0].empty() ? 1u : 0u) << object.label;
      without += summary.without_points;
    }
  }
  EXPECT_GT(without, 1000u);
  EXPECT_LT(without, 6200u);
  ASSERT_NE(find(check, "box without points"), nullptr);
  EXPECT_EQ(find(check, "box without points")->count, without);
  EXPECT_EQ(find(check, "broken"), nullptr);
  EXPECT_EQ(find(check, "empty scan"), nullptr);
}

TEST(DatasetCheck, BoxesFarBeyondAllMeasureAreCheckedAsWell) {
  MadeDataset dataset;
  for (std::uint32_t i = 0; i < 1000; ++i) {
    dataset.scenes.push_back(random_scene(i, {0, 0, 0}, 1.0));
    dataset.scenes.back().objects[0].box.center = {1e200, -1e36, 0};
    dataset.scenes.back().objects[1].box.size = {1e35, 1e36, 1e9};
    dataset.scenes.back().objects[1].box.center.setZero();
    if (i == 501) dataset.scenes.back().cloud.values.assign(9, NAN);
    if (i == 503) dataset.scenes.back().objects[2].box.size.x() = NAN;
  }
  const auto check = io::check_dataset(dataset, "all");
  EXPECT_EQ(check.classes.at("7.0").without_points, 1u);
  EXPECT_EQ(check.classes.at("7.1").without_points, 0u);
  EXPECT_EQ(check.classes.at("501.1").without_points, 1u);
  ASSERT_NE(find(check, "empty scan"), nullptr);
  EXPECT_EQ(find(check, "empty scan")->examples, std::vector<std::string>{"501"});
  ASSERT_NE(find(check, "broken"), nullptr);
  EXPECT_EQ(find(check, "broken")->count, 1u);
}

TEST(DatasetCheck, EveryFindingAboutLabelsSaysHowToMendIt) {
  MadeDataset dataset;
  for (std::uint32_t i = 0; i < 8; ++i) {
    LabeledScene scene = testing::made_scene("s", 1 + i, io::SceneFrame::kLidar, {"a", "b"},
                                             testing::MadeBoxes::kUpright);
    for (LabeledObject& object : scene.objects) object.box.size *= 0.5;
    scene.objects[0].box.size.x() = 70;
    scene.objects[1].written_yaw = 90;
    scene.objects.push_back(scene.objects[2]);
    scene.objects.push_back(
        {.label = "a", .box = geometry::make_yaw_box({0, 0, 500}, {1, 1, 1}, 0)});
    dataset.scenes.push_back(scene);
  }
  dataset.scenes[7].cloud.values.clear();
  dataset.scenes[7].point_objects.clear();
  const auto check = io::check_dataset(dataset, "all");
  for (const char* kind :
       {"degrees", "empty scan", "box without points", "large box", "doubled box"}) {
    EXPECT_NE(find(check, kind), nullptr) << kind;
  }
  for (const auto& finding : check.findings) {
    EXPECT_FALSE(finding.mend.empty()) << finding.kind;
    EXPECT_GT(finding.count, 0u) << finding.kind;
  }
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
