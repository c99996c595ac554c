#include <Eigen/Cholesky>
#include <string>

#include "arbox/base/error.h"
#include "arbox/simulation/internal/object_sizes.h"

namespace arbox::simulation {
namespace {

struct SizeStatistics {
  std::string_view label;
  Eigen::Vector3d mean, deviation;
  double lw, lh, wh;  // correlations
  Eigen::Vector3d low, high;
};

const SizeStatistics kSizes[] = {
    {"Car",
     {3.884, 1.629, 1.526},
     {0.426, 0.102, 0.137},
     0.35,
     0.17,
     0.30,
     {2.94, 1.36, 1.27},
     {4.89, 1.88, 1.97}},
    {"Van",
     {5.078, 1.902, 2.207},
     {0.831, 0.173, 0.325},
     0.65,
     0.82,
     0.67,
     {3.72, 1.56, 1.71},
     {6.86, 2.46, 2.87}},
    {"Truck",
     {10.109, 2.585, 3.252},
     {2.858, 0.216, 0.449},
     0.41,
     0.21,
     0.38,
     {5.42, 2.06, 2.32},
     {16.79, 2.97, 4.19}},
    {"Pedestrian",
     {0.842, 0.660, 1.761},
     {0.235, 0.143, 0.113},
     0.20,
     0.27,
     0.13,
     {0.30, 0.38, 1.50},
     {1.32, 0.96, 1.97}},
    {"Person_sitting",
     {0.802, 0.595, 1.275},
     {0.222, 0.079, 0.110},
     -0.33,
     0.18,
     0.33,
     {0.50, 0.48, 1.06},
     {1.33, 0.75, 1.64}},
    {"Cyclist",
     {1.764, 0.597, 1.737},
     {0.177, 0.124, 0.095},
     0.32,
     0.37,
     0.13,
     {1.19, 0.34, 1.44},
     {2.12, 0.88, 1.97}},
    {"Tram",
     {16.094, 2.544, 3.529},
     {7.852, 0.215, 0.176},
     0.02,
     -0.21,
     0.10,
     {9.0, 2.17, 3.17},
     {35.24, 2.81, 3.84}},
    {"Misc",
     {3.576, 1.514, 1.907},
     {2.858, 0.674, 0.814},
     0.74,
     0.74,
     0.65,
     {1.47, 0.75, 0.93},
     {8.0, 2.57, 3.48}},
};

}  // namespace

Eigen::Vector3d draw_size(std::string_view label, Dice& dice) {
  for (const SizeStatistics& sizes : kSizes) {
    if (sizes.label != label) continue;
    Eigen::Matrix3d correlation;
    correlation << 1, sizes.lw, sizes.lh, sizes.lw, 1, sizes.wh, sizes.lh, sizes.wh, 1;
    const Eigen::Matrix3d root = correlation.llt().matrixL();
    Eigen::Vector3d draw;
    for (double& value : draw) value = dice.normal(0, 1);
    const Eigen::Vector3d size = sizes.mean + sizes.deviation.cwiseProduct(root * draw);
    return size.cwiseMax(sizes.low).cwiseMin(sizes.high);
  }
  throw InvalidArgument("draw_size: no size statistics for class '" + std::string(label) + "'");
}

}  // namespace arbox::simulation
