#include "arbox/io/dataset.h"

#include <algorithm>
#include <array>

#include "arbox/base/error.h"
#include "arbox/base/options.h"
#include "arbox/io/internal/dataset_layouts.h"
#include "arbox/io/internal/text.h"

namespace arbox::io {
namespace {

using namespace internal;

struct Layout {
  std::string_view name;
  /// What its folder has, for people.
  std::string_view signs;
  bool (*fits)(const Folder&);
  Reader (*open)(const Folder&, const DatasetOptions&);
  Writer (*create)(const NewDataset&);
};

// A folder takes the first layout that fits.
constexpr std::array kLayouts = {
    Layout{"kitti", "training/ or testing/ with velodyne/, label_2/, calib/", fits_kitti,
           open_kitti, create_kitti},
    Layout{"scannet-votenet", "SCENE_vert.npy and SCENE_bbox.npy", fits_scannet_votenet,
           open_scannet_votenet, create_scannet_votenet},
    Layout{"scannet", "scans/SCENE/SCENE_vh_clean_2.ply", fits_scannet_raw, open_scannet_raw,
           create_scannet_raw},
    Layout{"sunrgbd", "depth/, calib/ and label/", fits_sunrgbd, open_sunrgbd, create_sunrgbd},
    Layout{"sunrgbd-votenet", "SCENE_pc.npz and SCENE_bbox.npy", fits_sunrgbd_votenet,
           open_sunrgbd_votenet, create_sunrgbd_votenet},
    Layout{"sunrgbd-toolbox", "SUNRGBDMeta3DBB_v2.mat", fits_sunrgbd_toolbox, open_sunrgbd_toolbox,
           create_sunrgbd_toolbox},
    Layout{"cob3d-v2", "dset.json and scenes/", fits_cob3d_v2, open_cob3d_v2, create_cob3d_v2},
    Layout{"cob3d", "SPLIT/00000/data.npz", fits_cob3d, open_cob3d, create_cob3d},
    Layout{"scannet-mmdet3d", "scannet_infos_*.pkl and points/", fits_mmdet3d_scannet,
           open_mmdet3d_scannet, create_mmdet3d_scannet},
    Layout{"sunrgbd-mmdet3d", "sunrgbd_infos_*.pkl and points/", fits_mmdet3d_sunrgbd,
           open_mmdet3d_sunrgbd, create_mmdet3d_sunrgbd},
    Layout{"labelcloud", "pointclouds/ and labels/", fits_labelcloud, open_labelcloud,
           create_labelcloud},
    Layout{"cvat", "tracklet_labels.xml", fits_cvat, open_cvat, create_cvat},
    Layout{"arbox", "dataset.json, or points/ and labels/", fits_arbox, open_arbox, create_arbox}};

const Layout& layout_named(std::string_view name) {
  for (const Layout& layout : kLayouts) {
    if (layout.name == name) return layout;
  }
  throw InvalidArgument("dataset layout: expected one of " + joined(dataset_layouts(), ", ") +
                        ", got " + quoted_text(name));
}

void require_folder(const Folder& root) {
  std::error_code ignored;
  if (std::filesystem::is_directory(root, ignored)) return;
  throw IoError(root.string() + ": expected the folder of a dataset, got " +
                (std::filesystem::exists(root, ignored) ? "a file" : "no such folder"));
}

const Layout& layout_of(const Folder& root) {
  require_folder(root);
  for (const Layout& layout : kLayouts) {
    if (layout.fits(root)) return layout;
  }
  std::string known;
  for (const Layout& layout : kLayouts) {
    known.append(known.empty() ? "" : "; ").append(layout.name).append(": ").append(layout.signs);
  }
  throw FormatError(root.string() + ": looks like no dataset that is known (" + known +
                    "); say which with the option layout, or give its parent folder");
}

}  // namespace

DatasetReader::~DatasetReader() = default;
DatasetWriter::~DatasetWriter() = default;

std::vector<std::string> dataset_layouts() {
  std::vector<std::string> names;
  for (const Layout& layout : kLayouts) names.emplace_back(layout.name);
  return names;
}

std::string guess_layout(const std::filesystem::path& root) {
  return std::string(layout_of(root).name);
}

std::unique_ptr<DatasetReader> open_dataset(const std::filesystem::path& root,
                                            const DatasetOptions& options) {
  validate_options(options, "open_dataset");
  require_folder(root);
  const Layout& layout = options.layout.empty() ? layout_of(root) : layout_named(options.layout);
  return layout.open(root, options);
}

std::unique_ptr<DatasetWriter> create_dataset(const std::filesystem::path& root,
                                              const std::string& layout, SceneFrame frame,
                                              const std::vector<std::string>& classes,
                                              const DatasetWriteOptions& options) {
  validate_options(options, "create_dataset");
  const Layout& entry = layout_named(layout);
  std::error_code ignored;
  if (std::filesystem::exists(root, ignored) && !std::filesystem::is_empty(root, ignored)) {
    throw IoError(root.string() + ": expected a new or empty folder to write a dataset into");
  }
  make_folder(root);
  return entry.create({root, frame, classes, options});
}

}  // namespace arbox::io
