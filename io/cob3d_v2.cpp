#include <algorithm>
#include <cmath>

#include "arbox/base/error.h"
#include "arbox/io/cob3d.h"
#include "arbox/io/internal/image_arrays.h"
#include "arbox/io/npz.h"
#include "arbox/io/numpy_pickle.h"

namespace arbox::io {
namespace {

constexpr double kOrthogonal = 1e-3;

/// The dictionary that a member of the archive is: an array without shape of one Python object.
PickleValue dictionary(const NpzFile& archive, const std::string& place, const char* name) {
  const std::string where = place + ": " + name;
  const NumpyObjects objects = parse_npy_objects(archive.bytes(name), where);
  if (objects.values.size() != 1 || !objects.values[0].is(PickleKind::kDict)) {
    throw FormatError(where + ": expected one dictionary");
  }
  return objects.values[0];
}

/// Rows of three numbers; one row stands for all.
std::vector<double> three_each(const PickleValue& value, std::size_t count) {
  const NpyArray array = numpy_array(value);
  const std::vector<double> numbers = array.values<double>();
  if (numbers.size() == 3 * count) return numbers;
  std::vector<double> result;
  for (std::size_t i = 0; i < 3 * count; ++i) {
    if (numbers.size() == 3) {
      result.push_back(numbers[i % 3]);
    } else if (numbers.size() == count) {
      result.push_back(numbers[i / 3]);
    } else if (numbers.size() == 1) {
      result.push_back(numbers[0]);
    } else {
      throw FormatError(value.place() + ": expected three numbers an object (" +
                        std::to_string(count) + " objects), got " + std::to_string(numbers.size()));
    }
  }
  return result;
}

geometry::Box box_of(const Eigen::Matrix4d& pose, const Eigen::Vector3d& half,
                     const std::string& place) {
  Eigen::Matrix3d axes = pose.topLeftCorner<3, 3>();
  geometry::Box box{.center = pose.topRightCorner<3, 1>()};
  for (int i = 0; i < 3; ++i) {
    const double length = axes.col(i).norm();
    box.size[i] = 2.0 * std::abs(half[i]) * length;
    axes.col(i) /= length;
  }
  if (!(axes.transpose() * axes).isIdentity(kOrthogonal)) {
    throw FormatError(place + ": expected a pose with orthogonal axes");
  }
  if (axes.determinant() < 0.0) axes.col(2) *= -1.0;
  box.rotation = geometry::Quaternion(axes).normalized();
  try {
    geometry::require_valid(box, place);
  } catch (const InvalidArgument& error) {
    throw FormatError(error.what());
  }
  return box;
}

void read_objects(LabeledScene& scene, const NpzFile& archive, const std::string& place) {
  const PickleValue poses = dictionary(archive, place, "obj_poses");
  const NpyArray matrices = numpy_array(poses.at("poses"));
  const std::size_t count = matrices.shape().empty() ? 0 : matrices.shape()[0];
  internal::require_shape(matrices, {count, 4, 4}, poses.at("poses").place(), "poses");
  const auto numbers = matrices.values<double>();
  const auto scales = three_each(poses.at("scales"), count);
  const auto extents = three_each(dictionary(archive, place, "voxel_grid").at("extents"), count);
  for (std::size_t i = 0; i < count; ++i) {
    const Eigen::Matrix4d pose =
        Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(numbers.data() + 16 * i);
    const Eigen::Vector3d half = Eigen::Map<const Eigen::Array3d>(extents.data() + 3 * i) /
                                 Eigen::Map<const Eigen::Array3d>(scales.data() + 3 * i);
    scene.objects.push_back({.label = "object",
                             .box = box_of(pose, half, place + ": object " + std::to_string(i)),
                             .heading = Heading::kUnknown});
  }
}

}  // namespace

LabeledScene read_cob3d_v2_scene(const std::filesystem::path& file) {
  LabeledScene scene{.name = file.stem().string(), .source = file, .frame = SceneFrame::kCamera};
  const std::string place = file.string();
  const NpzFile archive = open_npz(file);
  const auto has = [&](std::string_view name) {
    const auto& names = archive.names();
    return std::find(names.begin(), names.end(), name) != names.end();
  };
  for (const char* needed : {"depth_map", "intrinsic"}) {
    if (!has(needed)) throw FormatError(place + ": expected an array '" + needed + "'");
  }
  RgbdImages& images = scene.images.emplace();
  internal::set_depth(images, archive.read("depth_map"), place + ": depth_map");
  internal::set_intrinsic(images, archive.read("intrinsic"), place + ": intrinsic");
  if (has("rgb")) internal::set_rgb(images, archive.read("rgb"), place + ": rgb");
  if (has("normal_map")) {
    internal::set_normals(images, archive.read("normal_map"), place + ": normal_map");
  }
  scene.labelled = has("obj_poses") && has("voxel_grid");
  if (scene.labelled) read_objects(scene, archive, place);
  if (has("segm")) {
    const PickleValue segments = dictionary(archive, place, "segm");
    const auto masks = [&](const char* name) {
      const PickleValue value = segments.at(name);
      return internal::masks_of(images, numpy_array(value), value.place());
    };
    images.visible_masks = masks("masks");
    images.amodal_masks = masks("amodal_masks");
    if (scene.labelled && images.visible_masks.size() != scene.objects.size()) {
      throw FormatError(place + ": expected one mask an object");
    }
  }
  internal::fill_cloud(scene);
  return scene;
}

}  // namespace arbox::io
