#include <array>
#include <cmath>

#include "arbox/base/error.h"
#include "arbox/io/internal/text.h"
#include "arbox/io/sunrgbd.h"

namespace arbox::io {
namespace {

using internal::LineReader;
using internal::refuse;

constexpr std::size_t kFields = 13;
constexpr int kDecimals = 9;
constexpr double kRtiltTolerance = 1e-3;
constexpr std::array<std::string_view, kFields> kSunRgbdFields = {
    "class", "left", "top", "width", "height", "cx", "cy", "cz", "c1", "c2", "c3", "ox", "oy"};

SunRgbdLabel parse_line(const LineReader& lines) {
  const auto place = lines.place();
  const auto fields = internal::split_white_space(lines.line());
  if (fields.size() != kFields) {
    refuse(place, "13 fields (class, 2-D box, centre, half sizes, heading)",
           std::to_string(fields.size()));
  }
  std::array<double, kFields> v{};
  for (std::size_t i = 1; i < kFields; ++i) {
    v[i] = internal::parse_number(fields[i], kSunRgbdFields[i], place);
    if (i >= 8 && i < 11 && v[i] == 0.0) {
      refuse(place, "a half size above zero as " + std::string(kSunRgbdFields[i]), "0");
    }
  }
  if (v[11] == 0.0 && v[12] == 0.0) refuse(place, "a heading ox oy", "0 0");
  return {.label = std::string(fields[0]),
          .left = v[1],
          .top = v[2],
          .width = v[3],
          .height = v[4],
          .center = {v[5], v[6], v[7]},
          .half_size = {std::abs(v[8]), std::abs(v[9]), std::abs(v[10])},
          .heading = {v[11], v[12]}};
}

Eigen::Matrix3d parse_matrix(LineReader& lines, const char* what) {
  if (!lines.next_filled()) refuse(lines.place(), what, "the end of the file");
  const auto fields = internal::split_white_space(lines.line());
  if (fields.size() != 9) refuse(lines.place(), what, std::to_string(fields.size()) + " fields");
  Eigen::Matrix3d matrix;
  for (std::size_t i = 0; i < 9; ++i) {
    matrix(static_cast<int>(i % 3), static_cast<int>(i / 3)) =
        internal::parse_number(fields[i], what, lines.place());
  }
  return matrix;
}

/// From the upright depth frame's axes to those of a camera (x right, y down, z forward).
Eigen::Matrix3d camera_axes() {
  Eigen::Matrix3d axes;
  axes << 1, 0, 0, 0, 0, -1, 0, 1, 0;
  return axes;
}

double attribute(const LabeledObject& object, const char* name) {
  const auto found = object.attributes.find(name);
  return found == object.attributes.end() ? 0.0 : found->second;
}

}  // namespace

std::vector<std::string> sunrgbd_class_names() {
  return {"bed",  "table",   "sofa",        "chair",     "toilet",
          "desk", "dresser", "night_stand", "bookshelf", "bathtub"};
}

std::vector<SunRgbdLabel> parse_sunrgbd_labels(std::string_view text, std::string_view source) {
  std::vector<SunRgbdLabel> labels;
  LineReader lines(text, source);
  while (lines.next_filled()) labels.push_back(parse_line(lines));
  return labels;
}

std::string format_sunrgbd_labels(std::span<const SunRgbdLabel> labels) {
  std::string text;
  for (const SunRgbdLabel& label : labels) {
    if (label.label.empty() || label.label.find_first_of(" \t\r\n\v\f") != std::string::npos) {
      throw InvalidArgument("format_sunrgbd_labels: a class must be a word without blanks, got " +
                            internal::quoted_text(label.label));
    }
    text += label.label;
    for (const double number :
         {label.left, label.top, label.width, label.height, label.center.x(), label.center.y(),
          label.center.z(), label.half_size.x(), label.half_size.y(), label.half_size.z(),
          label.heading.x(), label.heading.y()}) {
      text += ' ';
      internal::append_fixed(text, number, kDecimals);
    }
    text += '\n';
  }
  return text;
}

LabeledObject to_object(const SunRgbdLabel& label) {
  const Eigen::Vector3d size =
      2.0 * Eigen::Vector3d(label.half_size.y(), label.half_size.x(), label.half_size.z());
  return {.label = label.label,
          .box = geometry::make_yaw_box(label.center, size,
                                        std::atan2(label.heading.y(), label.heading.x())),
          .heading = Heading::kKnown,
          .attributes = {{"left", label.left},
                         {"top", label.top},
                         {"right", label.left + label.width},
                         {"bottom", label.top + label.height}}};
}

SunRgbdLabel to_sunrgbd_label(const LabeledObject& object) {
  const geometry::Box& box = object.box;
  if (!geometry::is_yaw_only(box, 1e-6)) {
    throw InvalidArgument("to_sunrgbd_label: expected a box that stands upright");
  }
  const double yaw = geometry::yaw(box), left = attribute(object, "left"),
               top = attribute(object, "top");
  SunRgbdLabel label{.label = object.label,
                     .left = left,
                     .top = top,
                     .width = attribute(object, "right") - left,
                     .height = attribute(object, "bottom") - top,
                     .center = box.center,
                     .half_size = 0.5 * Eigen::Vector3d(box.size.y(), box.size.x(), box.size.z()),
                     .heading = {std::cos(yaw), std::sin(yaw)}};
  for (char& letter : label.label) {
    if (static_cast<unsigned char>(letter) <= ' ') letter = '_';
  }
  return label;
}

SunRgbdCalibration parse_sunrgbd_calibration(std::string_view text, std::string_view source) {
  LineReader lines(text, source);
  SunRgbdCalibration calibration;
  calibration.tilt = parse_matrix(lines, "nine numbers of Rtilt, columns first");
  if (!(calibration.tilt * calibration.tilt.transpose()).isIdentity(kRtiltTolerance) ||
      calibration.tilt.determinant() < 0.0) {
    refuse(lines.place(), "a rotation as Rtilt", "a matrix that is none");
  }
  calibration.intrinsic = parse_matrix(lines, "nine numbers of K, columns first");
  if (!(std::abs(calibration.intrinsic.determinant()) > 0.0)) {
    refuse(lines.place(), "an invertible K", "a singular one");
  }
  return calibration;
}

std::string format_sunrgbd_calibration(const SunRgbdCalibration& calibration) {
  std::string text;
  for (const Eigen::Matrix3d& matrix : {calibration.tilt, calibration.intrinsic}) {
    for (int i = 0; i < 9; ++i) {
      if (i > 0) text += ' ';
      internal::append_number(text, matrix(i % 3, i / 3));
    }
    text += '\n';
  }
  return text;
}

Projection projection_of(const SunRgbdCalibration& calibration) {
  Projection result = Projection::Zero();
  result.leftCols<3>() = calibration.intrinsic * camera_axes() * calibration.tilt.transpose();
  return result;
}

std::optional<SunRgbdCalibration> calibration_of(const Projection& projection) {
  const Eigen::Matrix3d matrix = projection.leftCols<3>();
  const double scale = matrix.row(2).norm();
  if (!matrix.allFinite() || !(scale > 0.0) || !(std::abs(matrix.determinant()) > 0.0) ||
      projection.col(3).norm() > 1e-6 * matrix.norm()) {
    return std::nullopt;
  }
  // Rows from the last one up: K is upper triangular and the rotation's rows are orthonormal.
  const Eigen::Matrix3d m = matrix / scale;
  Eigen::Matrix3d turn, intrinsic = Eigen::Matrix3d::Zero();
  for (int row = 2; row >= 0; --row) {
    Eigen::RowVector3d rest = m.row(row);
    for (int other = row + 1; other < 3; ++other) {
      intrinsic(row, other) = rest.dot(turn.row(other));
      rest -= intrinsic(row, other) * turn.row(other);
    }
    intrinsic(row, row) = rest.norm();
    turn.row(row) = rest / intrinsic(row, row);
  }
  if (turn.determinant() < 0.0) return std::nullopt;
  return SunRgbdCalibration{.tilt = (camera_axes().transpose() * turn).transpose(),
                            .intrinsic = intrinsic};
}

}  // namespace arbox::io
