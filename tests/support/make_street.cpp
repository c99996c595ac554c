#include <filesystem>
#include <iostream>

#include "arbox/io/file.h"
#include "arbox/io/kitti.h"
#include "arbox/io/kitti_calibration.h"
#include "arbox/io/kitti_label.h"
#include "support/street_scene.h"

/// \file
/// Writes the made street as street.bin, with labels and calibration in KITTI's layout beside it.

namespace {

using arbox::io::KittiCalibration;
using arbox::io::KittiObject;

constexpr arbox::io::ImageSize kImage{1242, 375};
constexpr int kFewestReturns = 5;

/// An ideal camera 0.27 m ahead of the scanner and 0.08 m below it.
KittiCalibration made_calibration() {
  KittiCalibration calibration;
  arbox::io::Projection projection;
  projection << 720, 0, 620, 0, 0, 720, 187, 0, 0, 0, 1, 0;
  calibration.projections[2] = projection;
  calibration.velodyne_to_camera.matrix() << 0, -1, 0, 0, 0, 0, -1, -0.08, 1, 0, 0, -0.27, 0, 0, 0,
      1;
  return calibration;
}

/// The share of the projected box outside of the image.
double truncation(const KittiObject& object, const KittiCalibration& calibration) {
  const auto area = [](const arbox::io::ImageBox& box) {
    return (box.right - box.left) * (box.bottom - box.top);
  };
  const auto whole = projected_box(object, calibration);
  const auto inside = whole ? clipped(*whole, kImage) : std::nullopt;
  return inside ? 1.0 - area(*inside) / area(*whole) : 1.0;
}

/// 0 fully visible, 1 partly hidden, 2 largely hidden.
int occlusion(double visible) { return visible > 0.8 ? 0 : (visible > 0.4 ? 1 : 2); }

std::vector<KittiObject> labels(const arbox::testing::StreetScene& scene,
                                const KittiCalibration& calibration) {
  std::vector<KittiObject> objects;
  for (std::size_t i = 0; i < scene.truth.size(); ++i) {
    if (scene.returns[i] < kFewestReturns) continue;
    for (KittiObject object : to_kitti_results({&scene.truth[i], 1}, calibration, kImage)) {
      object.truncation = truncation(object, calibration);
      object.occlusion = occlusion(scene.visible[i]);
      objects.push_back(object);
    }
  }
  return objects;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::cerr << "usage: make_street FOLDER\n";
    return 2;
  }
  try {
    const std::filesystem::path folder = argv[1];
    const auto scene = arbox::testing::make_street();
    const auto& values = scene.cloud.values;
    const std::filesystem::path training = folder / "kitti" / "training";
    for (const char* name : {"velodyne", "calib", "label_2"}) {
      std::filesystem::create_directories(training / name);
    }
    arbox::io::write_file(folder / "street.bin", {reinterpret_cast<const char*>(values.data()),
                                                  values.size() * sizeof(float)});
    const std::filesystem::path link = training / "velodyne" / "000000.bin";
    std::filesystem::remove(link);
    std::filesystem::create_symlink("../../../street.bin", link);
    const KittiCalibration calibration = made_calibration();
    arbox::io::write_file(training / "calib" / "000000.txt", format_kitti_calibration(calibration));
    arbox::io::write_file(training / "label_2" / "000000.txt",
                          format_kitti_labels(labels(scene, calibration)));
  } catch (const std::exception& error) {
    std::cerr << "make_street: " << error.what() << '\n';
    return 1;
  }
}
