#pragma once

#include "arbox/base/option_field.h"
#include "arbox/detectors/detector_kind.h"

/// \file
/// The classical baseline: ground removal, Euclidean clusters, L-shape fitting, size priors. It
/// learns nothing and knows nothing but sizes; docs/detectors/cluster_fit.md tells its limits.

namespace arbox::detectors {

/// How the ground surface is tracked outwards from the sensor, in sectors around it.
struct GroundOptions {
  /// Points up to this height above the surface belong to the ground.
  double thickness = 0.2;
  /// The nearest ground may tilt up to this slope (rise over run).
  double max_slope = 0.3;
  /// Expected change of the slope from one metre to the next.
  double slope_change = 0.012;
  /// The lowest return of a bin farther from the expected height is an obstacle or a ghost.
  double max_step = 0.45;

  template <class Visitor>
  static void describe(Visitor& visitor) {
    visitor.field("thickness", &GroundOptions::thickness,
                  {.help = "Points up to this height above the ground surface belong to it",
                   .unit = "m",
                   .low = 0.01,
                   .high = 2});
    visitor.field("max_slope", &GroundOptions::max_slope,
                  {.help = "Largest slope of the ground around the sensor (rise over run)",
                   .low = 0,
                   .high = 1});
    visitor.field("slope_change", &GroundOptions::slope_change,
                  {.help = "Expected change of the slope per metre", .low = 0, .high = 1});
    visitor.field("max_step", &GroundOptions::max_step,
                  {.help = "Largest step of the ground against its expected height",
                   .unit = "m",
                   .low = 0.01,
                   .high = 5});
  }
};

struct ClusterFitOptions {
  /// Points farther from the sensor are not used.
  double max_range = 80.0;
  GroundOptions ground = {};
  /// Points higher above the ground are not used: tree crowns, bridges.
  double max_height = 2.8;
  /// One point is kept of each cube of this edge. 0 keeps all.
  double thinning = 0.05;
  /// Points within this distance belong to one cluster (pcl::EuclideanClusterExtraction).
  double tolerance = 0.5;
  /// A cluster larger than any object is split with half the tolerance, down to this one.
  double min_tolerance = 0.12;
  /// Clusters with fewer points are left out.
  int min_points = 8;
  /// Step of the search over headings; the best is refined to a hundredth of it.
  double yaw_step = 2.0;
  /// Of two boxes that overlap more than this in bird's eye view the better one stays.
  double nms_iou = 0.1;
  /// Box samples drawn for quantile boxes, uncertainty and DetectionRequest::samples.
  int sample_count = 64;

  template <class Visitor>
  static void describe(Visitor& visitor) {
    using Options = ClusterFitOptions;
    visitor.field("max_range", &Options::max_range,
                  {.help = "Points farther from the sensor are not used",
                   .unit = "m",
                   .low = 1,
                   .high = 1000});
    visitor.group("ground", &Options::ground, "How the ground surface is found");
    visitor.field("max_height", &Options::max_height,
                  {.help = "Points higher above the ground are not used",
                   .unit = "m",
                   .low = 0.1,
                   .high = 100});
    visitor.field("thinning", &Options::thinning,
                  {.help = "One point is kept of each cube of this edge; 0 keeps all",
                   .unit = "m",
                   .low = 0,
                   .high = 1});
    visitor.field("tolerance", &Options::tolerance,
                  {.help = "Points within this distance belong to one cluster",
                   .unit = "m",
                   .low = 0.05,
                   .high = 10});
    visitor.field("min_tolerance", &Options::min_tolerance,
                  {.help = "Clusters larger than any object are split with half the tolerance, "
                           "again and again, down to this one",
                   .unit = "m",
                   .low = 0.05,
                   .high = 10});
    visitor.field("min_points", &Options::min_points,
                  {.help = "Clusters with fewer points are left out",
                   .unit = "points",
                   .low = 3,
                   .high = 1000000});
    visitor.field("yaw_step", &Options::yaw_step,
                  {.help = "Step of the search over headings, refined afterwards",
                   .unit = "degrees",
                   .low = 0.1,
                   .high = 15});
    visitor.field("nms_iou", &Options::nms_iou,
                  {.help = "Of two boxes that overlap more than this in bird's eye view the better "
                           "one stays",
                   .low = 0,
                   .high = 1});
    visitor.field(
        "sample_count", &Options::sample_count,
        {.help = "Box samples drawn for quantile boxes and uncertainty", .low = 1, .high = 100000});
  }
};

/// Finds Car, Pedestrian and Cyclist in a scan of a sensor that stands at the frame's origin.
///
/// Stages: (1) the ground, tracked outwards in sectors by a Kalman filter of height and slope;
/// (2) Euclidean clusters of what stands on it; (3) the yaw rectangle whose visible sides lie
/// closest to the points (after Zhang et al., "Efficient L-Shape Fitting for Vehicle Detection
/// Using Laser Scanners", IV 2017); (4) the hidden ends completed from the sizes of each class, as
/// a posterior given how much was seen; (5) the class whose sizes explain the extents best.
///
/// Box samples (for quantile boxes, uncertainty, DetectionRequest::samples) redraw the points of a
/// cluster and, from the posterior, what was not seen. Confidence boxes are the quantile boxes at
/// q = 1 - p, true to p as far as the samples are; no conformal table corrects them. `log_density`
/// stays empty. The heading is known up to a half turn only: it is given in (-90, 90] degrees.
///
/// Input: any cloud; only coordinates are used. Non-finite points are counted in
/// DetectionResult::dropped_points; an empty cloud, a single point, or nothing but ground gives no
/// detections. Cost: linear in the points, 24 bytes a point and less than 300 bytes a point that
/// stands above the ground.
///
/// Const, safe to use from several threads. Same cloud, options and seed: same bytes at any thread
/// count.
class ClusterFit : public Detector {
 public:
  /// Throws InvalidArgument if an option is out of its described range.
  explicit ClusterFit(const ClusterFitOptions& options = {});

  /// Throws InvalidArgument for quantiles or confidences outside of (0, 1) and a score outside of
  /// [0, 1].
  DetectionResult detect(const geometry::PointCloudView& cloud,
                         const DetectionRequest& request = {}) const override;

  const ClusterFitOptions& options() const { return options_; }

 private:
  ClusterFitOptions options_;
};

/// Adds the detector `cluster_fit`.
void register_cluster_fit(Registrar& registrar);

}  // namespace arbox::detectors
