#include <algorithm>
#include <cmath>
#include <set>

#include "arbox/base/error.h"
#include "arbox/io/internal/mat_access.h"
#include "arbox/io/internal/text.h"
#include "arbox/io/sunrgbd.h"

// The annotations of SUN RGB-D's own toolbox, structs in a MAT-file.

namespace arbox::io {
namespace {

namespace fs = std::filesystem;

constexpr const char* kAnnotationsVariable = "SUNRGBDMeta";
constexpr double kRigid = 1e-3;

std::size_t count_of(const matvar_t& variable) {
  std::size_t count = variable.rank > 0 ? 1 : 0;
  for (int i = 0; i < variable.rank; ++i) count *= variable.dims[i];
  return count;
}

/// One struct of an array of structs, with its place for messages.
class MatStruct {
 public:
  MatStruct(matvar_t* array, std::size_t index, std::string place)
      : array_(array), index_(index), place_(std::move(place)) {}

  [[noreturn]] void refuse(const std::string& name, const std::string& expected) const {
    throw FormatError(place_ + ": expected " + expected + " as " + name);
  }

  /// Null if there is no such field or it holds nothing.
  matvar_t* find(const char* name) const {
    matvar_t* field = Mat_VarGetStructFieldByName(array_, name, index_);
    return field == nullptr || count_of(*field) == 0 ? nullptr : field;
  }

  std::vector<double> numbers(const char* name, std::size_t count) const {
    const matvar_t* field = find(name);
    if (field == nullptr || field->class_type != MAT_C_DOUBLE || field->isComplex != 0 ||
        field->data == nullptr || field->data_type != MAT_T_DOUBLE || count_of(*field) != count ||
        field->nbytes < count * sizeof(double)) {
      refuse(name, std::to_string(count) + " numbers");
    }
    const auto* data = static_cast<const double*>(field->data);
    return {data, data + count};
  }

  std::string text(const char* name) const {
    const matvar_t* field = find(name);
    if (field == nullptr || field->class_type != MAT_C_CHAR || field->data == nullptr) {
      refuse(name, "text");
    }
    const bool wide = field->data_type == MAT_T_UINT16 || field->data_type == MAT_T_UTF16;
    // UTF-8 takes more bytes than characters.
    const std::size_t held = field->nbytes / (wide ? 2 : 1);
    const std::size_t count =
        field->data_type == MAT_T_UTF8 ? held : std::min(count_of(*field), held);
    std::string result;
    for (std::size_t i = 0; i < count; ++i) {
      result += wide ? static_cast<char>(static_cast<const std::uint16_t*>(field->data)[i])
                     : static_cast<const char*>(field->data)[i];
    }
    result.resize(result.find_last_not_of('\0') + 1);
    return result;
  }

  const std::string& place() const { return place_; }

 private:
  matvar_t* array_;
  std::size_t index_;
  std::string place_;
};

Eigen::Matrix3d matrix_of(const MatStruct& item, const char* name) {
  const std::vector<double> numbers = item.numbers(name, 9);
  return Eigen::Map<const Eigen::Matrix3d>(numbers.data());
}

/// The box with axes `basis` (one a row) and half sizes `coefficients`, its x axis along the one
/// that is nearest to the heading.
std::optional<geometry::Box> oriented_box(const Eigen::Vector3d& center,
                                          const Eigen::Matrix3d& basis,
                                          const Eigen::Vector3d& coefficients,
                                          const Eigen::Vector3d& heading) {
  int up = 0, front = -1;
  basis.col(2).cwiseAbs().maxCoeff(&up);
  double best = -1.0;
  for (int i = 0; i < 3; ++i) {
    const double along = std::abs(basis.row(i).dot(heading));
    if (i == up || !(along > best)) continue;
    best = along;
    front = i;
  }
  if (front < 0) return std::nullopt;
  const int side = 3 - up - front;
  Eigen::Vector3d x = basis.row(front).transpose().normalized();
  if (x.dot(heading) < 0.0) x = -x;
  const Eigen::Vector3d size =
      2.0 * Eigen::Vector3d(coefficients[front], coefficients[side], coefficients[up]).cwiseAbs();
  const geometry::Box box = geometry::make_yaw_box(center, size, std::atan2(x.y(), x.x()));
  if (!center.allFinite() || !size.allFinite() || !(size.array() > 0.0).all() || !x.allFinite()) {
    return std::nullopt;
  }
  return box;
}

std::optional<LabeledObject> read_object(const MatStruct& item) {
  const auto vector = [&](const char* name) {
    const std::vector<double> numbers = item.numbers(name, 3);
    return Eigen::Vector3d(numbers[0], numbers[1], numbers[2]);
  };
  const auto box = oriented_box(vector("centroid"), matrix_of(item, "basis"), vector("coeffs"),
                                vector("orientation"));
  if (!box) return std::nullopt;
  LabeledObject object{.label = item.text("classname"), .box = *box};
  if (item.find("gtBb2D") != nullptr) {
    const std::vector<double> image = item.numbers("gtBb2D", 4);
    object.attributes = {{"left", image[0]},
                         {"top", image[1]},
                         {"right", image[0] + image[2]},
                         {"bottom", image[1] + image[3]}};
  }
  return object;
}

SunRgbdAnnotation read_annotation(const MatStruct& item, std::size_t number) {
  SunRgbdAnnotation result;
  result.number = number;
  result.calibration.tilt = matrix_of(item, "Rtilt");
  result.calibration.intrinsic = matrix_of(item, "K");
  const Eigen::Matrix3d& tilt = result.calibration.tilt;
  if (!(tilt * tilt.transpose()).isIdentity(kRigid)) item.refuse("Rtilt", "a rotation");
  matvar_t* objects = item.find("groundtruth3DBB");
  if (objects == nullptr) return result;
  if (objects->class_type != MAT_C_STRUCT) item.refuse("groundtruth3DBB", "structs");
  for (std::size_t i = 0; i < count_of(*objects); ++i) {
    const MatStruct object(objects, i,
                           item.place() + ".groundtruth3DBB(" + std::to_string(i + 1) + ")");
    if (auto read = read_object(object)) result.objects.push_back(std::move(*read));
  }
  return result;
}

constexpr std::size_t kMostImages = 99999;
// As libmatio takes them, with a null pointer at the end.
constexpr const char* kMetaFields[] = {"sequenceName", "groundtruth3DBB", "K",
                                       "Rtilt",        "valid",           nullptr};
constexpr const char* kObjectFields[] = {"basis",       "coeffs", "centroid", "classname",
                                         "orientation", "gtBb2D", nullptr};

internal::MatVariable struct_array(const char* name, std::size_t count, const char* const* fields) {
  const std::size_t sizes[2] = {1, count};
  return internal::MatVariable(Mat_VarCreateStruct2(name, 2, sizes, fields));
}

void set_field(matvar_t& array, const char* field, std::size_t index, matio_classes kind,
               matio_types type, std::array<std::size_t, 2> sizes, const void* data) {
  // The library copies the data.
  matvar_t* value = Mat_VarCreate(field, kind, type, 2, sizes.data(), const_cast<void*>(data), 0);
  Mat_VarSetStructFieldByName(&array, field, index, value);
}

void set_numbers(matvar_t& array, const char* field, std::size_t index,
                 std::span<const double> values, std::size_t rows = 1) {
  set_field(array, field, index, MAT_C_DOUBLE, MAT_T_DOUBLE, {rows, values.size() / rows},
            values.data());
}

void set_text(matvar_t& array, const char* field, std::size_t index, const std::string& text) {
  set_field(array, field, index, MAT_C_CHAR, MAT_T_UTF8, {1, text.size()}, text.data());
}

void set_object(matvar_t& array, std::size_t index, const LabeledObject& object) {
  const SunRgbdLabel label = to_sunrgbd_label(object);
  const Eigen::Vector2d ahead = label.heading.normalized();
  Eigen::Matrix3d basis = Eigen::Matrix3d::Identity();
  // Across the heading, along it, up, as the half sizes come.
  basis.row(0) << ahead.y(), -ahead.x(), 0.0;
  basis.row(1) << ahead.x(), ahead.y(), 0.0;
  set_numbers(array, "basis", index, {basis.data(), 9}, 3);
  set_numbers(array, "coeffs", index, {label.half_size.data(), 3});
  set_numbers(array, "centroid", index, {label.center.data(), 3});
  set_text(array, "classname", index, object.label.empty() ? "object" : object.label);
  const std::array<double, 3> orientation = {ahead.x(), ahead.y(), 0.0};
  set_numbers(array, "orientation", index, orientation);
  if (!object.attributes.contains("right")) return;
  const std::array<double, 4> image = {label.left, label.top, label.width, label.height};
  set_numbers(array, "gtBb2D", index, image);
}

void set_image(matvar_t& meta, const SunRgbdAnnotation& annotation) {
  const std::size_t index = annotation.number - 1;
  set_text(meta, "sequenceName", index, std::to_string(annotation.number));
  set_numbers(meta, "Rtilt", index, {annotation.calibration.tilt.data(), 9}, 3);
  set_numbers(meta, "K", index, {annotation.calibration.intrinsic.data(), 9}, 3);
  const double valid = 1.0;
  set_numbers(meta, "valid", index, {&valid, 1});
  if (annotation.objects.empty()) return;
  internal::MatVariable objects =
      struct_array("groundtruth3DBB", annotation.objects.size(), kObjectFields);
  for (std::size_t i = 0; i < annotation.objects.size(); ++i) {
    set_object(*objects, i, annotation.objects[i]);
  }
  Mat_VarSetStructFieldByName(&meta, "groundtruth3DBB", index, objects.release());
}

}  // namespace

std::vector<SunRgbdAnnotation> read_sunrgbd_toolbox(const fs::path& path) {
  const internal::MatFile file(path);
  const std::scoped_lock lock(internal::mat_mutex());
  const internal::MatVariable variable = internal::read_variable(file, path, kAnnotationsVariable);
  if (variable->class_type != MAT_C_STRUCT) {
    throw FormatError(path.string() + ": expected an array of structs " + kAnnotationsVariable);
  }
  std::vector<SunRgbdAnnotation> result;
  for (std::size_t i = 0; i < count_of(*variable); ++i) {
    const MatStruct item(
        variable.get(), i,
        path.string() + ": " + kAnnotationsVariable + "(" + std::to_string(i + 1) + ")");
    // Numbers without an image are left empty.
    if (item.find("Rtilt") == nullptr && item.find("K") == nullptr) continue;
    result.push_back(read_annotation(item, i + 1));
  }
  return result;
}

void write_sunrgbd_toolbox(const fs::path& path, std::span<const SunRgbdAnnotation> annotations) {
  std::set<std::size_t> numbers;
  for (const SunRgbdAnnotation& annotation : annotations) {
    if (annotation.number < 1 || annotation.number > kMostImages ||
        !numbers.insert(annotation.number).second) {
      throw InvalidArgument("write_sunrgbd_toolbox: expected each number from 1 to " +
                            std::to_string(kMostImages) + " once, got " +
                            std::to_string(annotation.number));
    }
  }
  const std::scoped_lock lock(internal::mat_mutex());
  const internal::MatVariable meta =
      struct_array(kAnnotationsVariable, numbers.empty() ? 0 : *numbers.rbegin(), kMetaFields);
  for (const SunRgbdAnnotation& annotation : annotations) set_image(*meta, annotation);
  internal::write_variable(path, meta);
}

}  // namespace arbox::io
