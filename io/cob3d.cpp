#include "arbox/io/cob3d.h"

#include <algorithm>

#include "arbox/base/error.h"
#include "arbox/io/file.h"
#include "arbox/io/internal/dataset_layouts.h"
#include "arbox/io/internal/image_arrays.h"
#include "arbox/io/internal/rotation.h"
#include "arbox/io/npz.h"

namespace arbox::io {
namespace {

namespace fs = std::filesystem;

constexpr const char* kClass = "object";

NpyArray array_of(const NpzFile& archive, const std::string& place, const char* name) {
  const auto& names = archive.names();
  if (std::find(names.begin(), names.end(), name) == names.end()) {
    throw FormatError(place + ": expected an array '" + std::string(name) + "'");
  }
  return archive.read(name);
}

bool has(const NpzFile& archive, const char* name) {
  const auto& names = archive.names();
  return std::find(names.begin(), names.end(), name) != names.end();
}

void read_images(LabeledScene& scene) {
  const std::string place = scene.source.string();
  const NpzFile archive = open_npz(scene.source);
  RgbdImages& images = scene.images.emplace();
  internal::set_depth(images, array_of(archive, place, "depth"), place + ": depth");
  internal::set_intrinsic(images, array_of(archive, place, "intrinsic"), place + ": intrinsic");
  if (has(archive, "rgb")) internal::set_rgb(images, archive.read("rgb"), place + ": rgb");
  if (has(archive, "normals")) {
    internal::set_normals(images, archive.read("normals"), place + ": normals");
  }
}

void read_masks(LabeledScene& scene, const fs::path& path) {
  const NpzFile archive = open_npz(path);
  const auto masks = [&](const char* name) {
    return internal::masks_of(*scene.images, array_of(archive, path.string(), name),
                              path.string() + ": " + name);
  };
  scene.images->visible_masks = masks("masks");
  scene.images->amodal_masks = masks("masks_amodal");
}

void read_boxes(LabeledScene& scene, const fs::path& path) {
  const NpzFile archive = open_npz(path);
  const std::string place = path.string();
  const NpyArray dimensions = array_of(archive, place, "dimensions");
  const std::size_t count = dimensions.shape().empty() ? 0 : dimensions.shape()[0];
  const auto rows = [&](const NpyArray& array, const char* name, std::size_t columns) {
    internal::require_shape(array, {count, columns}, place + ": " + name, "one row an object");
    return array.values<double>();
  };
  const auto sizes = rows(dimensions, "dimensions", 3);
  const auto centers = rows(array_of(archive, place, "centers"), "centers", 3);
  const auto turns = rows(array_of(archive, place, "orientations"), "orientations", 4);
  for (std::size_t i = 0; i < count; ++i) {
    const std::string object = place + ": object " + std::to_string(i);
    const double* q = turns.data() + 4 * i;
    const auto rotation = internal::accepted_rotation({q[0], q[1], q[2], q[3]});
    if (!rotation) throw FormatError(object + ": expected a unit quaternion w x y z");
    scene.objects.push_back({.label = kClass,
                             .box = {.center = Eigen::Vector3d(centers.data() + 3 * i),
                                     .size = Eigen::Vector3d(sizes.data() + 3 * i),
                                     .rotation = *rotation},
                             .heading = Heading::kUnknown});
    try {
      geometry::require_valid(scene.objects.back().box, object);
    } catch (const InvalidArgument& error) {
      throw FormatError(error.what());
    }
  }
}

void write_boxes(const fs::path& path, const LabeledScene& scene) {
  std::vector<double> sizes, centers, turns;
  for (const LabeledObject& object : scene.objects) {
    const auto& box = object.box;
    sizes.insert(sizes.end(), box.size.data(), box.size.data() + 3);
    centers.insert(centers.end(), box.center.data(), box.center.data() + 3);
    turns.insert(turns.end(),
                 {box.rotation.w(), box.rotation.x(), box.rotation.y(), box.rotation.z()});
  }
  const std::size_t count = scene.objects.size();
  write_file(path, encode_npz({{"dimensions", encode_npy<double>(sizes, {count, 3})},
                               {"centers", encode_npy<double>(centers, {count, 3})},
                               {"orientations", encode_npy<double>(turns, {count, 4})}}));
}

}  // namespace

LabeledScene read_cob3d_scene(const fs::path& folder) {
  LabeledScene scene{.name = folder.filename().string(), .frame = SceneFrame::kCamera};
  scene.source = folder / "data.npz";
  read_images(scene);
  const fs::path masks = folder / "annotation" / "segm.npz";
  const fs::path boxes = folder / "annotation" / "bbox3d.npz";
  scene.labelled = fs::exists(boxes);
  if (scene.labelled) read_boxes(scene, boxes);
  if (fs::exists(masks)) read_masks(scene, masks);
  const std::size_t count = scene.images->visible_masks.size();
  if (scene.labelled && count != 0 && count != scene.objects.size()) {
    throw FormatError(masks.string() + ": expected one mask an object (" +
                      std::to_string(scene.objects.size()) + "), got " + std::to_string(count));
  }
  internal::fill_cloud(scene);
  return scene;
}

void write_cob3d_scene(const fs::path& folder, const LabeledScene& scene) {
  internal::require_cob3d_writable(scene, "write_cob3d_scene");
  internal::make_folder(folder / "annotation");
  const RgbdImages& images = *scene.images;
  const auto height = static_cast<std::size_t>(images.height);
  const auto width = static_cast<std::size_t>(images.width);
  const Eigen::Matrix<double, 3, 3, Eigen::RowMajor> intrinsic = images.intrinsic;
  std::vector<std::pair<std::string, std::string>> arrays = {
      {"depth", encode_npy<float>(images.depth, {height, width})},
      {"intrinsic", encode_npy<double>(std::span(intrinsic.data(), 9), {3, 3})}};
  if (!images.rgb.empty()) {
    arrays.emplace_back("rgb", internal::plane_array(images.rgb, 255.0F, height, width));
  }
  if (!images.normals.empty()) {
    arrays.emplace_back("normals", internal::plane_array(images.normals, 1.0F, height, width));
  }
  write_file(folder / "data.npz", encode_npz(arrays));
  if (images.visible_masks.size() == scene.objects.size()) {
    write_file(
        folder / "annotation" / "segm.npz",
        encode_npz({{"masks", internal::mask_array(images.visible_masks, height, width)},
                    {"masks_amodal", internal::mask_array(images.amodal_masks, height, width)}}));
  }
  if (scene.labelled) write_boxes(folder / "annotation" / "bbox3d.npz", scene);
}

}  // namespace arbox::io
