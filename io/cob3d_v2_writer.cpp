#include <algorithm>
#include <array>

#include "arbox/io/cob3d.h"
#include "arbox/io/file.h"
#include "arbox/io/internal/image_arrays.h"
#include "arbox/io/npz.h"
#include "arbox/io/pickle_writer.h"

namespace arbox::io {
namespace {

using Members = std::vector<std::pair<std::string, std::string>>;
using Masks = std::vector<std::vector<std::uint8_t>>;

/// A member that holds a dictionary, filled by `put`.
void add_dictionary(Members& members, const char* name, const auto& put) {
  PickleWriter pickle;
  pickle.begin_object_array();
  pickle.begin_dict();
  put(pickle);
  pickle.end();
  pickle.end();
  members.emplace_back(name, encode_npy_object(std::move(pickle).finish()));
}

void put_masks(PickleWriter& pickle, const char* name, const Masks& masks,
               const RgbdImages& images) {
  std::string all;
  for (const auto& mask : masks) all.append(mask.begin(), mask.end());
  pickle.text(name);
  pickle.array(NumberType::kBool,
               {masks.size(), static_cast<std::size_t>(images.height),
                static_cast<std::size_t>(images.width)},
               all);
}

/// left top right bottom of the set pixels; zeros if there are none.
std::array<double, 4> hull_of(const std::vector<std::uint8_t>& mask, int width) {
  Eigen::AlignedBox2d hull;
  for (std::size_t i = 0; i < mask.size(); ++i) {
    const auto pixel = static_cast<int>(i);
    if (mask[i] != 0) hull.extend(Eigen::Vector2d(pixel % width, pixel / width));
  }
  if (hull.isEmpty()) return {0, 0, 0, 0};
  return {hull.min().x(), hull.min().y(), hull.max().x(), hull.max().y()};
}

void add_masks(Members& members, const RgbdImages& images) {
  std::vector<double> boxes;
  for (const auto& mask : images.amodal_masks) {
    const auto box = hull_of(mask, images.width);
    boxes.insert(boxes.end(), box.begin(), box.end());
  }
  add_dictionary(members, "segm", [&](PickleWriter& pickle) {
    pickle.text("boxes"), pickle.array<double>(boxes, {images.amodal_masks.size(), 4});
    put_masks(pickle, "masks", images.visible_masks, images);
    put_masks(pickle, "amodal_masks", images.amodal_masks, images);
  });
}

void add_objects(Members& members, const LabeledScene& scene) {
  const std::size_t count = scene.objects.size();
  std::vector<double> poses, extents;
  for (const LabeledObject& object : scene.objects) {
    Eigen::Matrix<double, 4, 4, Eigen::RowMajor> pose = Eigen::Matrix4d::Identity();
    pose.topLeftCorner<3, 3>() = object.box.rotation.toRotationMatrix();
    pose.topRightCorner<3, 1>() = object.box.center;
    poses.insert(poses.end(), pose.data(), pose.data() + 16);
    for (int i = 0; i < 3; ++i) extents.push_back(0.5 * object.box.size[i]);
  }
  const std::vector<double> scales(3 * count, 1.0);
  add_dictionary(members, "obj_poses", [&](PickleWriter& pickle) {
    pickle.text("poses"), pickle.array<double>(poses, {count, 4, 4});
    pickle.text("scales"), pickle.array<double>(scales, {count, 3});
  });
  add_dictionary(members, "voxel_grid", [&](PickleWriter& pickle) {
    pickle.text("voxels");
    pickle.array(NumberType::kBool, {count, 1, 1, 1}, std::string(count, '\1'));
    pickle.text("extents"), pickle.array<double>(extents, {count, 3});
  });
}

}  // namespace

void write_cob3d_v2_scene(const std::filesystem::path& file, const LabeledScene& scene) {
  internal::require_cob3d_writable(scene, "write_cob3d_v2_scene");
  const RgbdImages& images = *scene.images;
  const auto height = static_cast<std::size_t>(images.height);
  const auto width = static_cast<std::size_t>(images.width);
  const Eigen::Matrix<double, 3, 3, Eigen::RowMajor> intrinsic = images.intrinsic;
  double nearest = 0.0, farthest = 0.0;
  for (const float depth : images.depth) {
    if (!(depth > 0.0F)) continue;
    nearest = nearest == 0.0 ? depth : std::min<double>(nearest, depth);
    farthest = std::max<double>(farthest, depth);
  }
  Members members = {{"depth_map", encode_npy<float>(images.depth, {height, width})},
                     {"intrinsic", encode_npy<double>({intrinsic.data(), 9}, {3, 3})},
                     {"near_plane", encode_npy<double>({&nearest, 1}, {})},
                     {"far_plane", encode_npy<double>({&farthest, 1}, {})}};
  if (!images.rgb.empty()) {
    members.emplace_back("rgb", internal::plane_array(images.rgb, 255.0F, height, width));
  }
  if (!images.normals.empty()) {
    members.emplace_back("normal_map", internal::plane_array(images.normals, 1.0F, height, width));
  }
  if (images.visible_masks.size() == scene.objects.size()) add_masks(members, images);
  if (scene.labelled) add_objects(members, scene);
  write_file(file, encode_npz(members));
}

}  // namespace arbox::io
