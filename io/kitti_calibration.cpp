#include "arbox/io/kitti_calibration.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <map>
#include <vector>

#include "arbox/io/file.h"
#include "arbox/io/internal/text.h"

namespace arbox::io {
namespace {

using internal::LineReader;
using internal::quoted_text;
using internal::refuse;
using internal::TextPlace;

constexpr double kRotationTolerance = 1e-3;

struct CalibrationEntry {
  std::vector<double> numbers;
  TextPlace place;
};

std::string_view canonical_name(std::string_view name) {
  if (name == "R_rect") return "R0_rect";
  if (name == "Tr_velo_cam") return "Tr_velo_to_cam";
  if (name == "Tr_imu_velo") return "Tr_imu_to_velo";
  return name;
}

std::size_t expected_numbers(std::string_view name) {
  if (name == "R0_rect") return 9;
  const bool known = name == "P0" || name == "P1" || name == "P2" || name == "P3" ||
                     name == "Tr_velo_to_cam" || name == "Tr_imu_to_velo";
  return known ? 12 : 0;
}

std::map<std::string_view, CalibrationEntry> read_entries(std::string_view text,
                                                          std::string_view source) {
  std::map<std::string_view, CalibrationEntry> entries;
  LineReader lines(text, source);
  while (lines.next_filled()) {
    const auto fields = internal::split_white_space(lines.line());
    std::string_view name = fields[0];
    if (name.ends_with(':')) name.remove_suffix(1);
    name = canonical_name(name);
    const std::size_t count = expected_numbers(name);
    if (count == 0) continue;
    if (fields.size() != count + 1) {
      refuse(lines.place(), std::to_string(count) + " numbers after " + std::string(name),
             std::to_string(fields.size() - 1));
    }
    CalibrationEntry entry{.numbers = {}, .place = lines.place()};
    for (std::size_t i = 1; i < fields.size(); ++i) {
      entry.numbers.push_back(internal::parse_number(fields[i], name, lines.place()));
    }
    if (!entries.emplace(name, std::move(entry)).second) {
      refuse(lines.place(), "each name once", quoted_text(name) + " twice");
    }
  }
  return entries;
}

void require_rotation(const Eigen::Matrix3d& r, std::string_view name, const TextPlace& place) {
  const double error = (r * r.transpose() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
  const double determinant = r.determinant();
  if (error <= kRotationTolerance && determinant > 0) return;
  std::string came = "one with determinant ";
  internal::append_number(came, determinant);
  came += " whose rows miss being orthonormal by ";
  internal::append_number(came, error);
  refuse(place, "a rotation matrix as " + std::string(name), came);
}

const CalibrationEntry& required(const std::map<std::string_view, CalibrationEntry>& entries,
                                 std::string_view name, std::string_view source) {
  const auto found = entries.find(name);
  if (found != entries.end()) return found->second;
  std::string there;
  for (const auto& [key, entry] : entries) there.append(there.empty() ? "" : " ").append(key);
  refuse({source}, "a line '" + std::string(name) + ": ...'",
         there.empty() ? "none of the names of a calibration" : "only " + there);
}

Projection to_projection(const CalibrationEntry& entry) { return Projection(entry.numbers.data()); }

AffineTransform to_transform(const CalibrationEntry& entry, std::string_view name) {
  const Projection matrix = to_projection(entry);
  require_rotation(matrix.leftCols<3>(), name, entry.place);
  AffineTransform transform = AffineTransform::Identity();
  transform.linear() = matrix.leftCols<3>();
  transform.translation() = matrix.col(3);
  return transform;
}

template <class Matrix>
void append_line(std::string& text, std::string_view name, const Matrix& matrix) {
  text.append(name).append(":");
  for (Eigen::Index row = 0; row < matrix.rows(); ++row) {
    for (Eigen::Index column = 0; column < matrix.cols(); ++column) {
      text += ' ';
      internal::append_number(text, matrix(row, column));
    }
  }
  text += '\n';
}

}  // namespace

AffineTransform KittiCalibration::rect_from_lidar() const {
  AffineTransform result = velodyne_to_camera;
  result.linear() = r0_rect * velodyne_to_camera.linear();
  result.translation() = r0_rect * velodyne_to_camera.translation();
  return result;
}

AffineTransform KittiCalibration::lidar_from_rect() const { return rect_from_lidar().inverse(); }

Projection image_from_lidar(const KittiCalibration& calibration) {
  const AffineTransform to_camera = calibration.rect_from_lidar();
  Projection result;
  result.leftCols<3>() = calibration.p2().leftCols<3>() * to_camera.linear();
  result.col(3) =
      calibration.p2().leftCols<3>() * to_camera.translation() + calibration.p2().col(3);
  return result;
}

KittiCalibration parse_kitti_calibration(std::string_view text, std::string_view source) {
  const auto entries = read_entries(text, source);
  KittiCalibration calibration;
  const CalibrationEntry& p2 = required(entries, "P2", source);
  const CalibrationEntry& r0 = required(entries, "R0_rect", source);
  const CalibrationEntry& velodyne = required(entries, "Tr_velo_to_cam", source);
  for (int camera = 0; camera < 4; ++camera) {
    const auto found = entries.find("P" + std::to_string(camera));
    if (found != entries.end()) calibration.projections[camera] = to_projection(found->second);
  }
  if (std::abs(calibration.p2().leftCols<3>().determinant()) < 1e-9) {
    refuse(p2.place, "an invertible left 3 x 3 part of P2", "a singular one");
  }
  calibration.r0_rect =
      Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(r0.numbers.data());
  require_rotation(calibration.r0_rect, "R0_rect", r0.place);
  calibration.velodyne_to_camera = to_transform(velodyne, "Tr_velo_to_cam");
  const auto imu = entries.find("Tr_imu_to_velo");
  if (imu != entries.end()) {
    calibration.imu_to_velodyne = to_transform(imu->second, "Tr_imu_to_velo");
  }
  return calibration;
}

KittiCalibration read_kitti_calibration(const std::filesystem::path& path) {
  return parse_kitti_calibration(read_file(path), path.string());
}

std::string format_kitti_calibration(const KittiCalibration& calibration) {
  std::string text;
  for (int camera = 0; camera < 4; ++camera) {
    const auto& projection = calibration.projections[camera];
    if (projection) append_line(text, "P" + std::to_string(camera), *projection);
  }
  append_line(text, "R0_rect", calibration.r0_rect);
  append_line(text, "Tr_velo_to_cam", calibration.velodyne_to_camera.affine());
  if (calibration.imu_to_velodyne) {
    append_line(text, "Tr_imu_to_velo", calibration.imu_to_velodyne->affine());
  }
  return text;
}

std::optional<ImageSize> known_image_size(const KittiCalibration& calibration) {
  struct Day {
    double focal_length, center_x;
    ImageSize size;
  };
  static constexpr Day kDays[] = {{721.5377, 609.5593, {1242, 375}},
                                  {707.0493, 604.0814, {1224, 370}},
                                  {718.3351, 600.3891, {1238, 374}},
                                  {718.8560, 607.1928, {1241, 376}}};
  const Projection& p2 = calibration.p2();
  for (const Day& day : kDays) {
    if (std::abs(p2(0, 0) - day.focal_length) < 1e-3 && std::abs(p2(0, 2) - day.center_x) < 1e-3) {
      return day.size;
    }
  }
  return std::nullopt;
}

KittiPlane parse_kitti_plane(std::string_view text, std::string_view source) {
  LineReader lines(text, source);
  std::optional<KittiPlane> plane;
  while (lines.next_filled()) {
    const auto fields = internal::split_white_space(lines.line());
    if (fields[0].starts_with('#')) continue;
    if (fields.size() == 2 && (fields[0] == "WIDTH" || fields[0] == "HEIGHT")) {
      const std::string_view expected = fields[0] == "WIDTH" ? "4" : "1";
      if (fields[1] == expected) continue;
      refuse(lines.place(), std::string(fields[0]) + " " + std::string(expected),
             quoted_text(fields[1]));
    }
    if (plane) refuse(lines.place(), "one plane", "a second line of numbers");
    if (fields.size() != 4) {
      refuse(lines.place(), "four numbers a b c d", std::to_string(fields.size()) + " fields");
    }
    Eigen::Vector4d numbers;
    for (int i = 0; i < 4; ++i) {
      numbers[i] = internal::parse_number(fields[i], "a coefficient of the plane", lines.place());
    }
    const double length = numbers.head<3>().norm();
    if (!(length > 1e-9) || !std::isfinite(length)) {
      refuse(lines.place(), "a normal a b c that is not zero", "one of length zero");
    }
    numbers /= numbers.y() > 0 ? -length : length;
    plane = KittiPlane{.normal = numbers.head<3>(), .offset = numbers[3]};
  }
  if (!plane) refuse({source}, "a line of four numbers a b c d", "none");
  return *plane;
}

KittiPlane read_kitti_plane(const std::filesystem::path& path) {
  return parse_kitti_plane(read_file(path), path.string());
}

KittiPlane plane_in_lidar(const KittiPlane& plane, const KittiCalibration& calibration) {
  const AffineTransform rect_from_lidar = calibration.rect_from_lidar();
  const Eigen::Vector3d normal = rect_from_lidar.linear().transpose() * plane.normal;
  const double offset = plane.normal.dot(rect_from_lidar.translation()) + plane.offset;
  return {.normal = normal.normalized(), .offset = offset / normal.norm()};
}

}  // namespace arbox::io
