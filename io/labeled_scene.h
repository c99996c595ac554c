#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "arbox/geometry/box.h"
#include "arbox/geometry/point_cloud_view.h"
#include "arbox/io/image_size.h"
#include "arbox/io/kitti_calibration.h"

/// \file
/// A scan with labelled objects, of whatever dataset it came: what every reader gives and every
/// writer takes. All numbers follow docs/conventions.md; what a dataset does otherwise ends in its
/// reader.

namespace arbox::io {

/// Frames of docs/conventions.md.
enum class SceneFrame { kLidar, kRoom, kCamera };

/// "lidar", "room", "camera".
std::string_view name_of(SceneFrame frame);

/// The frame of that name. Throws InvalidArgument.
SceneFrame frame_named(std::string_view name);

/// What is known of which way an object faces.
enum class Heading {
  /// The box's +x axis is the object's front.
  kKnown,
  /// The axes are known, front and back are not: turned by half a turn it is the same box.
  kHalfKnown,
  /// The box is one of 24 equal ones, or drawn along the frame's axes whatever the object does.
  kUnknown
};

/// "known", "half", "unknown".
std::string_view name_of(Heading heading);

/// The heading of that name. Throws InvalidArgument.
Heading heading_named(std::string_view name);

struct LabeledObject {
  std::string label = {};
  geometry::Box box = {};
  Heading heading = Heading::kKnown;
  /// What else the dataset says, by its own name: KITTI's `truncation`, `occlusion`, `alpha`; the
  /// 2-D box `left top right bottom` (pixels) of KITTI and SUN RGB-D; numbers of the own format.
  std::map<std::string, double> attributes = {};
  /// The angle about z as a file of the own format has it, where it has one; checks look at it.
  std::optional<double> written_yaw = {};
};

/// A colour picture taken with the scan.
struct ScenePhoto {
  std::filesystem::path path = {};
  /// 0 x 0 if the dataset does not say.
  ImageSize size = {};
  /// Pixel (u, v) = (a, b) / w with (a, b, w) = projection * (p, 1) for a point p of the scene.
  Projection projection = Projection::Zero();
};

/// Pictures that a depth camera took, row by row from the top; the cloud is made of them.
struct RgbdImages {
  int width = 0, height = 0;
  /// Metres along the optical axis, width * height; 0 or not finite where nothing was measured.
  std::vector<float> depth = {};
  /// width * height * 3 bytes, or empty.
  std::vector<std::uint8_t> rgb = {};
  /// width * height * 3 unit vectors in the camera frame, towards the camera; or empty.
  std::vector<float> normals = {};
  /// Pinhole matrix, pixels; whole numbers are centres of pixels.
  Eigen::Matrix3d intrinsic = Eigen::Matrix3d::Identity();
  /// One mask an object (width * height, 0 or 1): what is seen of it, and what would be seen if
  /// nothing stood before it. As many as objects, or none.
  std::vector<std::vector<std::uint8_t>> visible_masks = {}, amodal_masks = {};
};

/// A scan and the objects in it.
struct LabeledScene {
  /// Its name in the dataset.
  std::string name = {};
  /// The file of the points, for messages.
  std::filesystem::path source = {};
  SceneFrame frame = SceneFrame::kLidar;
  /// In `frame`. Channels as of io/point_cloud_file.h (`intensity` and colours in 0..1).
  geometry::PointCloud cloud = {};
  std::vector<LabeledObject> objects = {};
  /// False if the dataset holds no labels for it (a test split), which is not the same as no
  /// objects.
  bool labelled = true;
  /// For each point the index of its object, -1 for none; empty if the dataset does not say.
  std::vector<std::int32_t> point_objects = {};
  std::optional<ScenePhoto> photo = {};
  std::optional<RgbdImages> images = {};
  /// KITTI's, if it came with the scan.
  std::optional<KittiCalibration> calibration = {};
};

/// The scene in another frame of docs/conventions.md: x y z of `room` (x right, y forward, z up)
/// are -y x z of `lidar` and x z -y of `camera`. Points, normals, boxes and the photo's projection
/// are turned; a KITTI calibration, which is of the LiDAR frame, is dropped, and so are `images`
/// unless the frame stays.
LabeledScene converted(const LabeledScene& scene, SceneFrame frame);

/// Indices of the points in each box grown by `margin` metres on every side, ascending. Points that
/// are not finite are in none. Threads do not change the result. Throws InvalidArgument for an
/// invalid box.
std::vector<std::vector<std::int32_t>> points_in_boxes(const geometry::PointCloudView& cloud,
                                                       const std::vector<geometry::Box>& boxes,
                                                       double margin = 0.0);

/// The points that a depth image shows: P = K^-1 (u, v, 1) depth(u, v), whole pixels (u, v), in the
/// camera frame, with channels r g b and normal_x normal_y normal_z where there are such images.
/// Pixels whose depth is not a finite number above 0 have no point.
geometry::PointCloud to_cloud(const RgbdImages& images);

/// Pixel index (row * width + column) of every point of to_cloud(images).
std::vector<std::int32_t> pixels_of_cloud(const RgbdImages& images);

}  // namespace arbox::io
