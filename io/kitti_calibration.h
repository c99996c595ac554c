#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "arbox/io/image_size.h"

/// \file
/// Calibration and ground plane of a KITTI frame.

namespace arbox::io {

/// Unaligned on purpose, so that the layout does not depend on a caller's -march flags.
using Projection = Eigen::Matrix<double, 3, 4, Eigen::RowMajor | Eigen::DontAlign>;
using AffineTransform = Eigen::Transform<double, 3, Eigen::Affine, Eigen::DontAlign>;

/// How the sensors of a frame stand to each other. Metres and pixels.
struct KittiCalibration {
  /// P0..P3: from the rectified frame of camera 0 to pixels of camera i; P2, the left colour
  /// camera, is always there.
  std::array<std::optional<Projection>, 4> projections;
  /// From camera 0 to its rectified frame (x right, y down, z forward).
  Eigen::Matrix3d r0_rect = Eigen::Matrix3d::Identity();
  /// From the LiDAR (x forward, y left, z up) to camera 0.
  AffineTransform velodyne_to_camera = AffineTransform::Identity();
  std::optional<AffineTransform> imu_to_velodyne;

  const Projection& p2() const { return projections[2].value(); }
  /// r0_rect * velodyne_to_camera.
  AffineTransform rect_from_lidar() const;
  /// The inverse of rect_from_lidar().
  AffineTransform lidar_from_rect() const;
};

/// From the LiDAR frame to pixels of the left colour image: P2 * rect_from_lidar().
Projection image_from_lidar(const KittiCalibration& calibration);

/// Reads lines "NAME: numbers" in any order; names are looked up, never counted. P2, R0_rect and
/// Tr_velo_to_cam are required (the tracking benchmark's R_rect and Tr_velo_cam are taken too);
/// P0, P1, P3 and Tr_imu_to_velo may be missing, other names are passed over.
///
/// Throws FormatError with file, line, what was expected and what came for missing and doubled
/// names, wrong counts, numbers that are not finite, rotations that are not orthonormal with
/// determinant 1 within 1e-3, and a P2 whose left 3 x 3 part is singular.
KittiCalibration parse_kitti_calibration(std::string_view text, std::string_view source);

/// The same from a file; throws IoError for a missing file or a directory.
KittiCalibration read_kitti_calibration(const std::filesystem::path& path);

/// The calibration in the benchmark's layout, 17 significant digits.
std::string format_kitti_calibration(const KittiCalibration& calibration);

/// The image size of the recording day with this P2, for frames whose image is not there: KITTI's
/// 7481 training frames come from four days with one camera calibration each. Nothing for others.
std::optional<ImageSize> known_image_size(const KittiCalibration& calibration);

/// What images of KITTI's left colour camera have where nothing better is known.
inline constexpr ImageSize kUsualImageSize{1242, 375};

/// The ground: points p of the rectified camera frame with normal . p + offset = 0. The normal has
/// unit length and points up (negative y).
struct KittiPlane {
  Eigen::Vector3d normal = -Eigen::Vector3d::UnitY();
  double offset = 0.0;
};

/// Reads a planes/ID.txt: comment lines, WIDTH 4, HEIGHT 1, and one line of four numbers, which
/// are normalised and turned up. Throws FormatError for anything else.
KittiPlane parse_kitti_plane(std::string_view text, std::string_view source);
KittiPlane read_kitti_plane(const std::filesystem::path& path);

/// The plane in the LiDAR frame: normal . p + offset = 0 with a normal of unit length.
KittiPlane plane_in_lidar(const KittiPlane& plane, const KittiCalibration& calibration);

}  // namespace arbox::io
