#include <gtest/gtest.h>

#include <cctype>
#include <fstream>
#include <nlohmann/json.hpp>

#include "arbox/evaluation/kitti_files.h"
#include "arbox/evaluation/kitti_protocol.h"
#include "support/program.h"

/// \file
/// Equality with curves that the official C++ kit printed (recall easy moderate hard, 41 lines a
/// file) and with the AP table computed from them.

namespace arbox::evaluation {
namespace {

namespace fs = std::filesystem;

struct Golden {
  const char* suffix;
  std::optional<KittiCurves> KittiClassResult::*curves;
};
constexpr Golden kGolden[] = {{"detection_AP", &KittiClassResult::image},
                              {"orientation_AOS", &KittiClassResult::orientation},
                              {"detection_BEV_AP", &KittiClassResult::birds_eye},
                              {"detection_3D_AP", &KittiClassResult::box3d}};

std::string printed(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%f", value);
  return text;
}

void expect_curves(const fs::path& file, const KittiCurves& curves) {
  std::ifstream words(file);
  ASSERT_TRUE(words) << file;
  for (std::size_t i = 0; i < kKittiRecallPoints; ++i) {
    std::string recall;
    words >> recall;
    for (std::size_t d = 0; d < 3; ++d) {
      std::string expected;
      words >> expected;
      EXPECT_EQ(printed(curves[d].values[i]), expected)
          << file << ", point " << i << ", " << kKittiDifficulties[d];
    }
  }
}

void expect_table(const nlohmann::json& table, const KittiCurves& curves) {
  for (std::size_t d = 0; d < 3; ++d) {
    const nlohmann::json& expected = table.at(std::string(kKittiDifficulties[d]));
    // The table is made from the rounded curves.
    EXPECT_NEAR(curves[d].r40(), expected.at("AP_R40").get<double>(), 6e-5);
    EXPECT_NEAR(curves[d].r11(), expected.at("AP_R11").get<double>(), 6e-5);
  }
}

void expect_all(const fs::path& root, const std::string& set, const KittiReport& report,
                int curves_expected) {
  const nlohmann::json tables = nlohmann::json::parse(std::ifstream(root / "AP_TABLES.json"));
  int compared = 0;
  for (const KittiClassResult& result : report.classes) {
    std::string name = result.settings.name;
    for (char& letter : name) letter = static_cast<char>(std::tolower(letter));
    for (const Golden& golden : kGolden) {
      const std::string stem = name + "_" + golden.suffix;
      const auto& curves = result.*golden.curves;
      const fs::path file = root / set / "plot" / (stem + ".txt");
      ASSERT_EQ(curves.has_value(), fs::exists(file)) << file;
      if (!curves) continue;
      expect_curves(file, *curves);
      expect_table(tables.at(set).at("AP").at(stem), *curves);
      ++compared;
    }
  }
  EXPECT_EQ(compared, curves_expected);
}

TEST(KittiGolden, ThreeClassesOnTwoHundredFrames) {
  ARBOX_REQUIRE_DATA(root, "kitti_eval");
  const fs::path set = root / "subset200_mmdet3d";
  const KittiFrames read = read_kitti_frames(set / "label_2", set / "data", set / "frames.txt");
  EXPECT_EQ(read.frames.size(), 200u);
  expect_all(root, "subset200_mmdet3d", evaluate_kitti(read.frames), 12);
}

void unpack(const fs::path& archive, const fs::path& folder, const std::string& member) {
  const auto tar = arbox::testing::run("/usr/bin/tar",
                                       {"-xzf", archive.string(), "-C", folder.string(), member});
  ASSERT_EQ(tar.exit_code, 0) << tar.errors;
}

TEST(KittiGolden, CarsOnTheWholeValidationSplit) {
  ARBOX_REQUIRE_DATA(root, "kitti_eval");
  ARBOX_REQUIRE_DATA(labels, "kitti/kitti_object_labels_calib_all7481.tar.gz");
  ARBOX_REQUIRE_DATA(split, "kitti/ImageSets/val.txt");
  const arbox::testing::TemporaryDirectory folder;
  unpack(root / "pointgnn_car_val3769/data.tar.gz", folder.path(), "data");
  unpack(labels, folder.path(), "training/label_2");
  const KittiFrames read = read_kitti_frames(folder / "training/label_2", folder / "data", split);
  EXPECT_EQ(read.frames.size(), 3769u);
  expect_all(root, "pointgnn_car_val3769", evaluate_kitti(read.frames), 4);
}

}  // namespace
}  // namespace arbox::evaluation
