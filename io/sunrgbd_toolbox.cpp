#include <algorithm>
#include <cmath>
#include <map>

#include "arbox/base/error.h"
#include "arbox/io/internal/colored_rows.h"
#include "arbox/io/internal/dataset_layouts.h"
#include "arbox/io/internal/mat_access.h"
#include "arbox/io/internal/mat_file.h"
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
        field->data == nullptr || field->data_type != MAT_T_DOUBLE || count_of(*field) != count) {
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
    const std::size_t count = count_of(*field);
    std::string result;
    for (std::size_t i = 0; i < count; ++i) {
      const std::size_t unit = field->data_type == MAT_T_UINT16 || field->data_type == MAT_T_UTF16;
      result += unit != 0 ? static_cast<char>(static_cast<const std::uint16_t*>(field->data)[i])
                          : static_cast<const char*>(field->data)[i];
    }
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

}  // namespace

std::vector<SunRgbdAnnotation> read_sunrgbd_toolbox(const fs::path& path) {
  const std::scoped_lock lock(internal::mat_mutex());
  const internal::MatFile file = internal::open_mat(path);
  const internal::MatVariable variable(Mat_VarRead(file.get(), kAnnotationsVariable));
  if (!variable || variable->class_type != MAT_C_STRUCT) {
    throw FormatError(path.string() + ": expected an array of structs " + kAnnotationsVariable);
  }
  std::vector<SunRgbdAnnotation> result;
  for (std::size_t i = 0; i < count_of(*variable); ++i) {
    const MatStruct item(
        variable.get(), i,
        path.string() + ": " + kAnnotationsVariable + "(" + std::to_string(i + 1) + ")");
    result.push_back(read_annotation(item, i + 1));
  }
  return result;
}

namespace internal {
namespace {

constexpr std::array<std::string_view, 2> kMetaFiles = {"SUNRGBDMeta3DBB_v2.mat",
                                                        "SUNRGBDMeta3DBB.mat"};

fs::path meta_file(const Folder& root) {
  const std::array<std::string_view, 1> as_it_is = {""};
  for (const std::string_view name : kMetaFiles) {
    const fs::path path = first_file(root, name, as_it_is);
    if (!path.empty()) return path;
  }
  return {};
}

std::string six_digits(std::size_t number) {
  std::string text = std::to_string(number);
  return std::string(text.size() < 6 ? 6 - text.size() : 0, '0') + text;
}

class ToolboxReader : public ListedDataset {
 public:
  ToolboxReader(const Folder& folder, const DatasetOptions& options)
      : ListedDataset(folder), all_classes_(options.classes == "all") {
    source_ = meta_file(folder);
    if (source_.empty()) {
      throw IoError(folder.string() + ": expected SUNRGBDMeta3DBB_v2.mat of the toolbox");
    }
    std::vector<std::string> all;
    for (SunRgbdAnnotation& annotation : read_sunrgbd_toolbox(source_)) {
      all.push_back(six_digits(annotation.number));
      annotations_.emplace(all.back(), std::move(annotation));
    }
    add_split(std::string(kAllScenes), std::move(all));
  }

  std::string_view layout() const override { return "sunrgbd-toolbox"; }
  SceneFrame frame() const override { return SceneFrame::kRoom; }
  std::vector<std::string> classes() const override {
    return all_classes_ ? std::vector<std::string>{} : sunrgbd_class_names();
  }

  LabeledScene load(std::string_view split, std::string_view name) const override {
    require_scene(split, name);
    const SunRgbdAnnotation& annotation = annotations_.at(std::string(name));
    LabeledScene scene{.name = std::string(name), .source = source_, .frame = SceneFrame::kRoom};
    const auto known = sunrgbd_class_names();
    for (const LabeledObject& object : annotation.objects) {
      if (all_classes_ || std::find(known.begin(), known.end(), object.label) != known.end()) {
        scene.objects.push_back(object);
      }
    }
    const fs::path depth = root() / "depth" / (scene.name + ".mat");
    if (fs::exists(depth)) {
      MatMatrix matrix = read_mat_matrix(depth, "instance");
      scene.cloud = colored_cloud(std::move(matrix.values), matrix.columns);
      scene.source = depth;
    }
    const fs::path image = root() / "image" / (scene.name + ".jpg");
    if (fs::exists(image)) {
      scene.photo = {.path = image, .projection = projection_of(annotation.calibration)};
    }
    return scene;
  }

 private:
  bool all_classes_;
  fs::path source_;
  std::map<std::string, SunRgbdAnnotation> annotations_;
};

}  // namespace

bool fits_sunrgbd_toolbox(const Folder& root) { return !meta_file(root).empty(); }

Reader open_sunrgbd_toolbox(const Folder& root, const DatasetOptions& options) {
  return std::make_unique<ToolboxReader>(root, options);
}

}  // namespace internal
}  // namespace arbox::io
