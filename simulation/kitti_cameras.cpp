#include "arbox/simulation/kitti_cameras.h"

#include <array>
#include <string>

#include "arbox/base/error.h"

namespace arbox::simulation {
namespace {

struct Day {
  int frames;
  io::ImageSize image;
  double focal_length, center_x, center_y;
  std::array<double, 3> p2_shift;
  std::array<double, 12> velodyne_to_camera;
  std::array<double, 9> r0_rect;
};

constexpr Day kDays[kKittiCameraCount] = {
    {6057,
     {1242, 375},
     721.5377,
     609.5593,
     172.8540,
     {44.8573, 0.2164, 0.002746},
     {0.007533745, -0.9999714, -0.000616602, -0.004069766, 0.01480249, 0.0007280733, -0.9998902,
      -0.07631618, 0.9998621, 0.00752379, 0.01480755, -0.2717806},
     {0.9999239, 0.00983776, -0.007445048, -0.009869795, 0.9999421, -0.004278459, 0.007402527,
      0.004351614, 0.9999631}},
    {770,
     {1224, 370},
     707.0493,
     604.0814,
     180.5066,
     {45.7583, -0.3454, 0.004981},
     {0.006927964, -0.9999722, -0.002757829, -0.02457729, -0.001162982, 0.002749836, -0.9999955,
      -0.06127237, 0.9999753, 0.006931141, -0.001143899, -0.3321029},
     {0.9999128, 0.01009263, -0.008511932, -0.01012729, 0.9999406, -0.004037671, 0.008470675,
      0.004123522, 0.9999556}},
    {358,
     {1238, 374},
     718.3351,
     600.3891,
     181.5122,
     {44.5038, -0.5951, 0.002616},
     {0.007755449, -0.9999694, -0.001014303, -0.007275538, 0.002294056, 0.001032122, -0.9999968,
      -0.06324057, 0.9999673, 0.007753097, 0.00230199, -0.2670414},
     {0.9999478, 0.009791707, -0.002925305, -0.009806939, 0.9999382, -0.005238719, 0.002873828,
      0.005267134, 0.999982}},
    {296,
     {1241, 376},
     718.8560,
     607.1928,
     185.2157,
     {45.3822, -0.1131, 0.003780},
     {0.007967514, -0.9999679, -0.0008462264, -0.01377769, -0.002771053, 0.000824171, -0.9999958,
      -0.05542117, 0.9999644, 0.007969825, -0.002764397, -0.2918589},
     {0.9999454, 0.007259129, -0.007519551, -0.007292213, 0.9999638, -0.004381729, 0.007487471,
      0.004436324, 0.9999621}}};

}  // namespace

CameraView kitti_camera(int day) {
  if (day < 0 || day >= kKittiCameraCount) {
    throw InvalidArgument("kitti_camera: expected a day from 0 to 3, got " + std::to_string(day));
  }
  const Day& numbers = kDays[day];
  io::Projection base = io::Projection::Zero();
  base << numbers.focal_length, 0, numbers.center_x, 0, 0, numbers.focal_length, numbers.center_y,
      0, 0, 0, 1, 0;
  CameraView view;
  view.image = numbers.image;
  view.calibration.projections.fill(base);
  io::Projection& p2 = *view.calibration.projections[2];
  for (int row = 0; row < 3; ++row) p2(row, 3) = numbers.p2_shift[row];
  (*view.calibration.projections[1])(0, 3) = -0.537 * numbers.focal_length;
  (*view.calibration.projections[3])(0, 3) = -0.471 * numbers.focal_length;
  using Rows34 = Eigen::Matrix<double, 3, 4, Eigen::RowMajor>;
  using Rows33 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
  const Eigen::Map<const Rows34> velodyne(numbers.velodyne_to_camera.data());
  view.calibration.velodyne_to_camera.linear() = velodyne.leftCols<3>();
  view.calibration.velodyne_to_camera.translation() = velodyne.col(3);
  view.calibration.r0_rect = Eigen::Map<const Rows33>(numbers.r0_rect.data());
  view.calibration.imu_to_velodyne = io::AffineTransform::Identity();
  view.calibration.imu_to_velodyne->translation() << -0.81, 0.32, -0.80;
  return view;
}

int kitti_day(double uniform) {
  double draw = uniform;
  int total = 0;
  for (const Day& day : kDays) total += day.frames;
  for (int day = 0; day < kKittiCameraCount; ++day) {
    draw -= static_cast<double>(kDays[day].frames) / total;
    if (draw < 0.0) return day;
  }
  return kKittiCameraCount - 1;
}

}  // namespace arbox::simulation
