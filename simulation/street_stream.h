#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "arbox/geometry/box.h"
#include "arbox/geometry/point_cloud_view.h"
#include "arbox/simulation/labels.h"
#include "arbox/simulation/lidar_options.h"
#include "arbox/simulation/lidar_scan.h"
#include "arbox/simulation/street.h"

namespace arbox::simulation {

/// Everything that makes a simulated street scan.
struct StreetScanOptions {
  StreetOptions street;
  LabelOptions labels;
  LidarKind lidar = LidarKind::kHdl64;
  /// Returns as if the own vehicle stood still; KITTI's object scans are not compensated.
  bool motion_compensated = false;
  /// Recording day of the camera, 0..3; -1: drawn, as often as the benchmark has them.
  int camera = -1;

  template <class Visitor>
  static void describe(Visitor& visitor) {
    visitor.group("street", &StreetScanOptions::street, "What streets look like");
    visitor.group("labels", &StreetScanOptions::labels, "What is labelled");
    visitor.field("lidar", &StreetScanOptions::lidar,
                  {.help = "The scanner",
                   .choices = {"hdl64", "spinning16", "spinning32", "spinning128", "solid-state"}});
    visitor.field("motion_compensated", &StreetScanOptions::motion_compensated,
                  {.help = "Write scans as if the own vehicle stood still"});
    visitor.field("camera", &StreetScanOptions::camera,
                  {.help = "KITTI recording day of the camera calibration; -1 draws one",
                   .low = -1,
                   .high = 3});
  }
};

/// A scan with everything that is known of it.
struct StreetScan {
  Scene scene;
  CameraView camera;
  std::vector<LidarReturn> returns;
  /// Where the scan shows each of scene.objects (scanned_boxes): what the labels say.
  std::vector<geometry::Box> object_boxes;
  SceneLabels labels;

  /// The scan as x y z intensity.
  geometry::PointCloud cloud() const { return to_cloud(returns); }
  /// Boxes and classes of the objects in the camera's view (all_round: of all objects).
  std::vector<geometry::Box> boxes(bool all_round = false) const;
  std::vector<std::string> classes(bool all_round = false) const;
};

/// Scan number `index` of the streets with this seed, on the caller's thread, about 0.4 s. Depends
/// on its arguments alone. Throws ConfigError for options out of range.
StreetScan street_scan(const StreetScanOptions& options, std::uint64_t seed, std::uint64_t index);

/// Scans one after the other, for training without files. Copies go on independently; for several
/// threads give each a copy with its own `first` and a common `step`.
class StreetStream {
 public:
  explicit StreetStream(StreetScanOptions options = {}, std::uint64_t seed = 0,
                        std::uint64_t first = 0, std::uint64_t step = 1)
      : options_(std::move(options)), seed_(seed), next_(first), step_(step) {}

  StreetScan next();

 private:
  StreetScanOptions options_;
  std::uint64_t seed_, next_, step_;
};

}  // namespace arbox::simulation
