#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "arbox/geometry/overlap.h"
#include "arbox/io/kitti_object.h"

/// \file
/// Average precision as the official KITTI object benchmark computes it (Geiger et al., CVPR 2012;
/// the benchmark's C++ development kit), with intersection over ground truth (IoG; Liu et al.,
/// ECCV 2022, section 5.2) beside intersection over union (IoU).
///
/// Boxes stay in the files' own numbers (rectified camera frame, pixels): the protocol needs the
/// 2-D boxes, occlusion, truncation and DontCare regions that a geometry::Box does not carry.

namespace arbox::evaluation {

/// Labels and predictions of one image.
struct KittiFrame {
  std::vector<io::KittiObject> labels;
  std::vector<io::KittiObject> predictions;
};

/// The overlap that a prediction must exceed to match a label, for each metric.
struct KittiThresholds {
  double image = 0.5;
  double birds_eye = 0.5;
  double box3d = 0.5;
};

/// A class to be scored. Names are compared without case.
struct KittiClass {
  std::string name;
  /// Labels of these classes may be matched without reward or penalty (Van for Car).
  std::vector<std::string> neighbours;
  KittiThresholds min_overlap;
};

/// The benchmark's own settings of a class: Car (neighbour Van), Van and Truck 0.7; Pedestrian
/// (neighbour Person_sitting), Cyclist and Person_sitting 0.5; in all metrics. Empty for any other
/// name: the benchmark sets no overlap for it.
std::optional<KittiClass> kitti_class(std::string_view name);

/// Car, Pedestrian and Cyclist.
std::vector<KittiClass> kitti_benchmark_classes();

struct KittiOptions {
  std::vector<KittiClass> classes = kitti_benchmark_classes();
  /// kIou or kIog, in the 3-D metric.
  geometry::Overlap overlap = geometry::Overlap::kIou;
  /// The same in the bird's-eye metric. The 2-D metric is always IoU.
  geometry::Overlap birds_eye_overlap = geometry::Overlap::kIou;
  /// 0 means default_threads().
  int threads = 0;
};

inline constexpr std::size_t kKittiRecallPoints = 41;
inline constexpr std::array<std::string_view, 3> kKittiDifficulties = {"easy", "moderate", "hard"};

/// Precision (or orientation similarity) in [0, 1] at the recalls 0, 1/40, ..., 1, made monotone:
/// each value is the best at that or a higher recall, 0 where the recall is not reached.
struct KittiCurve {
  std::array<double, kKittiRecallPoints> values{};

  /// Mean of the points 1..40 in percent: the benchmark's figure since October 2019.
  double r40() const;
  /// Mean of the points 0, 4, ..., 40 in percent: the benchmark's earlier figure.
  double r11() const;
};

/// The easiest difficulty at which the benchmark counts a label, an index into kKittiDifficulties;
/// -1 for labels that it never counts. Decided by the height in the image, occlusion, truncation.
int kitti_difficulty(const io::KittiObject& label);

/// Three metrics at three difficulties are scored of each class.
inline constexpr std::int64_t kKittiCells = 9;

/// One curve a difficulty, in the order of kKittiDifficulties.
using KittiCurves = std::array<KittiCurve, 3>;

struct KittiClassResult {
  KittiClass settings;
  /// Labels that count at each difficulty, and predictions of the class.
  std::array<std::int64_t, 3> labels{};
  std::int64_t predictions = 0;
  /// Empty where the official kit computes nothing: no prediction of the class has a 2-D box with
  /// left >= 0 (image), an x other than -1000 (birds_eye), a y other than -1000 (box3d); a
  /// prediction of any class has alpha -10 (orientation).
  std::optional<KittiCurves> image;
  std::optional<KittiCurves> orientation;
  std::optional<KittiCurves> birds_eye;
  std::optional<KittiCurves> box3d;
};

struct KittiReport {
  geometry::Overlap overlap = geometry::Overlap::kIou;
  geometry::Overlap birds_eye_overlap = geometry::Overlap::kIou;
  std::int64_t frames = 0;
  /// In the order of the options.
  std::vector<KittiClassResult> classes;
};

/// Scores all classes, difficulties and metrics (2-D, orientation, bird's eye, 3-D).
///
/// A prediction or label without a 3-D box (a size that is not above zero) overlaps nothing in the
/// bird's-eye and 3-D metrics. No frames, or frames without objects, give a report without curves.
/// The result does not depend on `threads`. Cost: one overlap matrix a frame and metric, then one
/// matching a frame, class, metric, difficulty and recall point.
///
/// `scored` is called once for each of the kKittiCells cells of a class, from any thread.
///
/// Throws InvalidArgument if options.overlap is kIntersection, a threshold is outside of [0, 1), a
/// class is named twice, or a number of an object is not finite (naming frame and row).
KittiReport evaluate_kitti(std::span<const KittiFrame> frames, const KittiOptions& options = {},
                           const std::function<void()>& scored = {});

}  // namespace arbox::evaluation
