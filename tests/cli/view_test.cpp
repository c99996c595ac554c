#include <gtest/gtest.h>

#include <cstring>

#include "arbox/drawing/image.h"
#include "drawing/pixels.h"
#include "support/program.h"

namespace arbox::testing {
namespace {

using drawing::class_color;
using drawing::count_color;
using drawing::Image;
using drawing::read_image;

const char* const kBoxes =
    R"({"source": "scan.bin", "frame": "lidar", "detections": [
         {"class": "Car", "score": 0.9, "box": {"center": [10, 2, -1], "size": [4, 2, 1.5],
          "rotation": [1, 0, 0, 0]}},
         {"class": "Pedestrian", "score": 0.2, "box": {"center": [5, -5, -1],
          "size": [0.8, 0.8, 1.8], "rotation": [1, 0, 0, 0]}}]})";

// P2 of a camera that looks along x, 100 pixels focal length.
const char* const kCalibration =
    "P2: 100 0 100 0 0 100 50 0 0 0 1 0\n"
    "R0_rect: 1 0 0 0 1 0 0 0 1\n"
    "Tr_velo_to_cam: 0 -1 0 0 0 0 -1 0 1 0 0 0\n";

const char* const kLabel = "Car 0 0 0 10 10 50 50 1.5 2 4 0 1 10 -1.57\n";

class View : public ::testing::Test {
 protected:
  View() {
    std::vector<float> numbers;
    for (int i = 0; i < 3000; ++i) {
      for (const float v : {0.01f * (i % 1900), 0.013f * i - 20.0f, -1.7f, 0.3f}) {
        numbers.push_back(v);
      }
    }
    std::string bytes(numbers.size() * sizeof(float), '\0');
    std::memcpy(bytes.data(), numbers.data(), bytes.size());
    cloud_ = folder_.write("scan.bin", bytes).string();
    boxes_ = folder_.write("boxes.json", kBoxes).string();
    labels_ = folder_.write("label.txt", kLabel).string();
    calibration_ = folder_.write("calib.txt", kCalibration).string();
    output_ = (folder_ / "out.png").string();
  }

  Image picture(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), {"view", "--cloud", cloud_, "--output", output_});
    const RunResult result = run_arbox(arguments);
    EXPECT_EQ(result.exit_code, 0) << result.errors;
    EXPECT_EQ(result.output, "");
    return read_image(output_);
  }

  void refused(int exit_code, const std::vector<std::string>& arguments,
               const std::vector<std::string>& parts) {
    std::vector<std::string> all = {"view", "--cloud", cloud_, "--output", output_};
    all.insert(all.end(), arguments.begin(), arguments.end());
    expect_one_line_error(run_arbox(all), exit_code, parts);
    EXPECT_FALSE(std::filesystem::exists(output_));
  }

  TemporaryDirectory folder_;
  std::string cloud_, boxes_, labels_, calibration_, output_;
};

TEST_F(View, DrawsACloudAlone) {
  const Image image = picture({"--width", "800", "--height", "500"});
  EXPECT_EQ(image.width, 800);
  EXPECT_EQ(image.height, 500);
}

TEST_F(View, DrawsPredictionsInTheColorsOfTheirClasses) {
  const Image image = picture({"--boxes", boxes_, "--view", "birdseye"});
  EXPECT_GT(count_color(image, class_color("Car"), 15), 100);
  EXPECT_GT(count_color(image, class_color("Pedestrian"), 15), 20);
  const Image fewer = picture({"--boxes", boxes_, "--view", "birdseye", "--minimum-score", "0.5"});
  EXPECT_GT(count_color(fewer, class_color("Car"), 15), 100);
  EXPECT_EQ(count_color(fewer, class_color("Pedestrian"), 15), 0);
}

TEST_F(View, KittiLabelsAndCsvOfTheSameBoxGiveTheSamePicture) {
  const std::string csv =
      folder_.write("boxes.csv", "x,y,z,l,w,h,yaw,class\n10,0,-0.25,4,2,1.5,-0.0007963267949,Car\n")
          .string();
  const Image from_kitti = picture({"--labels", labels_, "--calib", calibration_});
  const Image from_csv = picture({"--labels", csv});
  EXPECT_EQ(from_kitti.pixels, from_csv.pixels);
}

TEST_F(View, ADepthCamerasCloudIsShownAsTheCameraSeesIt) {
  // Right of the camera is right in the picture (-y from above), up is up (x), near is high (z).
  const auto rows = [](auto&& place) {
    std::string text = "x,y,z\n";
    for (int i = 0; i < 2000; ++i) {
      const double right = 0.001 * (i % 500), down = 0.0007 * i, forward = 1.0 + 0.05 * (i % 7);
      text += place(right, down, forward) + "\n";
    }
    return text;
  };
  const auto joined = [](double a, double b, double c) {
    return std::to_string(a) + "," + std::to_string(b) + "," + std::to_string(c);
  };
  const auto boxes = [](const std::string& center, const std::string& rotation) {
    return R"({"source": "a", "detections": [{"class": "Car", "score": 1, "box": {"center": [)" +
           center + R"(], "size": [0.4, 0.2, 0.1], "rotation": [)" + rotation + "]}}]}";
  };
  const std::string half = "0.70710678118654752";
  cloud_ = folder_.write("seen.csv", rows(joined)).string();
  boxes_ = folder_.write("seen.json", boxes("0.2, 0.5, 1.2", "1, 0, 0, 0")).string();
  const Image seen = picture({"--frame", "camera", "--boxes", boxes_});
  cloud_ = folder_
               .write("turned.csv",
                      rows([&](double r, double d, double f) { return joined(-d, -r, -f); }))
               .string();
  boxes_ =
      folder_.write("turned.json", boxes("-0.5, -0.2, -1.2", "0, " + half + ", -" + half + ", 0"))
          .string();
  const Image turned = picture({"--boxes", boxes_});
  ASSERT_EQ(seen.pixels.size(), turned.pixels.size());
  std::size_t different = 0;
  for (std::size_t i = 0; i < seen.pixels.size(); ++i) {
    different += seen.pixels[i] != turned.pixels[i] ? 1 : 0;
  }
  EXPECT_LT(different, seen.pixels.size() / 1000);
  std::filesystem::remove(output_);
  refused(2, {"--frame", "camera", "--calib", calibration_}, {"--frame", "--calib"});
}

TEST_F(View, DrawsBoxesOverThePhoto) {
  const std::string photo = (folder_ / "photo.png").string();
  drawing::write_image(Image(200, 100, {255, 255, 255}), photo);
  const Image image =
      picture({"--labels", labels_, "--calib", calibration_, "--image", photo, "--width", "820"});
  const int strip = 380;  // the photo is drawn four times as large
  EXPECT_GT(count_color(image, class_color("Car"), 0, 0, image.width, strip, 40), 100);
  EXPECT_EQ(count_color(image, class_color("Car"), 0, 0, 250, strip, 40), 0);
}

TEST_F(View, PicksTheScanOfJsonLinesByName) {
  const std::string lines =
      R"({"source": "other.bin", "detections": [{"class": "Cyclist", "score": 1, "box": {"center": [8, 0, -1], "size": [2, 1, 2], "yaw": 0}}]})"
      "\n"
      R"({"source": "in/scan.bin", "detections": [{"class": "Car", "score": 1, "box": {"center": [8, 0, -1], "size": [4, 2, 2], "yaw": 0}}]})"
      "\n";
  const std::string path = folder_.write("all.jsonl", lines).string();
  const Image image = picture({"--boxes", path});
  EXPECT_GT(count_color(image, class_color("Car"), 15), 100);
  EXPECT_EQ(count_color(image, class_color("Cyclist"), 5), 0);
  std::filesystem::remove(output_);
  std::filesystem::rename(cloud_, folder_ / "third.bin");
  cloud_ = (folder_ / "third.bin").string();
  refused(1, {"--boxes", path}, {"all.jsonl", "2 scans", "third"});
}

TEST_F(View, TakesTheCloudOrTheBoxesFromStandardInput) {
  picture({"--boxes", boxes_});
  const std::string expected = slurp(output_);
  const RunResult boxes = run_arbox(
      {"view", "--cloud", cloud_, "--output", output_, "--boxes", "-"}, {.input = kBoxes});
  EXPECT_EQ(boxes.exit_code, 0) << boxes.errors;
  EXPECT_EQ(slurp(output_), expected);
  const RunResult cloud =
      run_arbox({"view", "--cloud", "-", "--output", output_, "--boxes", boxes_, "--format", "bin"},
                {.input = slurp(cloud_)});
  EXPECT_EQ(cloud.exit_code, 0) << cloud.errors;
  EXPECT_EQ(slurp(output_), expected);
  expect_one_line_error(run_arbox({"view", "--cloud", "-", "--boxes", "-", "--output", output_}), 2,
                        {"standard input"});
}

TEST_F(View, IsDeterministic) {
  picture({"--boxes", boxes_});
  const std::string first = slurp(output_);
  picture({"--boxes", boxes_, "--threads", "1"});
  EXPECT_EQ(slurp(output_), first);
}

TEST_F(View, RefusesWrongUsageWithCode2) {
  refused(2, {"--labels", labels_}, {"label.txt", "--calib"});
  refused(2, {"--image", "photo.png"}, {"--image", "--calib"});
  refused(2, {"--boxes", "boxes.xml"}, {"boxes.xml", ".json"});
  refused(2, {"--view", "sideways"}, {"birdseye", "sideways"});
  refused(2, {"--width", "3"}, {"--width", "320"});
  refused(2, {"--colour", "height"}, {"--colour"});
  expect_one_line_error(run_arbox({"view", "--cloud", cloud_}), 2, {"--output"});
  expect_one_line_error(run_arbox({"view", "--cloud", cloud_, "--output", "a.gif"}), 2,
                        {"a.gif", ".png"});
}

TEST_F(View, FailsWithCode1OnBadFiles) {
  refused(1, {"--boxes", (folder_ / "none.json").string()}, {"none.json"});
  refused(1, {"--labels", labels_, "--calib", labels_}, {"label.txt"});
  refused(1, {"--labels", labels_, "--calib", calibration_, "--image", labels_},
          {"label.txt", "image"});
  refused(1, {"--boxes", folder_.write("bad.json", "{\"detections\": 3}").string()}, {"bad.json"});
  refused(1, {"--color", "rgb"}, {"'r'", "intensity"});
  expect_one_line_error(run_arbox({"view", "--cloud", "none.bin", "--output", output_}), 1,
                        {"none.bin"});
  expect_one_line_error(
      run_arbox({"view", "--cloud", cloud_, "--output", (folder_ / "no" / "a.png").string()}), 1,
      {"a.png"});
}

TEST_F(View, DrawsARealFrame) {
  ARBOX_REQUIRE_DATA(root, "kitti/training");
  const auto file = [&](const char* folder, const char* extension) {
    return (root / folder / ("000008" + std::string(extension))).string();
  };
  const RunResult result = run_arbox({"view", "--cloud", file("velodyne", ".bin"), "--labels",
                                      file("label_2", ".txt"), "--calib", file("calib", ".txt"),
                                      "--image", file("image_2", ".png"), "--output", output_});
  ASSERT_EQ(result.exit_code, 0) << result.errors;
  const Image image = read_image(output_);
  EXPECT_EQ(image.width, 1800);
  EXPECT_GT(count_color(image, class_color("Car"), 15), 2000);
}

}  // namespace
}  // namespace arbox::testing
