#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <string>
#include <vector>

namespace arbox::benchmarks {

using Histogram = std::vector<double>;

/// What is told of one labelled object.
struct ObjectFigures {
  std::string type;
  double distance = 0, points = 0;
  int occlusion = 0;
  double truncation = 0;
  /// Nine numbers (kFeatureNames) of objects with ten points or more.
  Eigen::VectorXd features;

  /// Hardly occluded and whole.
  bool clear() const { return occlusion == 0 && truncation < 0.1; }
};

inline constexpr const char* kFeatureNames[] = {
    "log n d^2",     "length covered", "width covered", "height covered", "rings hit",
    "points a ring", "mean intensity", "intensity sd",  "zero intensity"};

/// What is told of one scan: only counts and quantiles, no points.
struct ScanFigures {
  double points = 0, in_image = 0;
  /// Counts by 1 m of range, ring from the top, intensity (0, then 20 bins), 5 degrees of azimuth.
  Histogram range = Histogram(80), ring = Histogram(64), intensity = Histogram(21),
            azimuth = Histogram(72);
  /// Heights of the ground by 2.5 m of distance: the lowest points of sectors of 10 degrees.
  std::vector<std::vector<double>> ground = std::vector<std::vector<double>>(20);
  std::vector<ObjectFigures> objects;
};

/// Figures of all frames of the training folder of a data set in KITTI's layout.
std::vector<ScanFigures> read_scans(const std::filesystem::path& root);

/// NaN for no values.
double quantile(std::vector<double> values, double q);

}  // namespace arbox::benchmarks
