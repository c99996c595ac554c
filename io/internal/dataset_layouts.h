#pragma once

#include <filesystem>
#include <memory>
#include <mutex>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "arbox/io/dataset.h"

/// \file
/// The layouts behind open_dataset and create_dataset, and what their readers and writers share.

namespace arbox::io::internal {

using Reader = std::unique_ptr<DatasetReader>;
using Writer = std::unique_ptr<DatasetWriter>;
using Folder = std::filesystem::path;

/// A dataset whose scenes are known when it is opened.
class ListedDataset : public DatasetReader {
 public:
  std::vector<std::string> splits() const override;
  std::vector<std::string> names(std::string_view split) const override;

 protected:
  explicit ListedDataset(Folder root) : root_(std::move(root)) {}
  void add_split(std::string name, std::vector<std::string> scenes);
  /// Throws InvalidArgument unless `split` is a split and `name` a scene of it or of the last one.
  void require_scene(std::string_view split, std::string_view name) const;
  const Folder& root() const { return root_; }

 private:
  Folder root_;
  std::vector<std::pair<std::string, std::vector<std::string>>> lists_;
};

inline constexpr std::string_view kAllScenes = "all";

/// Stems of the files of a folder whose name ends in `ending` (with the ending taken off), sorted;
/// none if there is no such folder.
std::vector<std::string> names_in(const Folder& folder, std::string_view ending);

/// The first of root/folder/name + one of the endings that is a file; an empty path if none is.
std::filesystem::path first_file(const Folder& folder, std::string_view name,
                                 std::span<const std::string_view> endings);

/// What boxes a layout holds.
enum class BoxForm { kAny, kUpright, kAxisAligned };

/// A writer that keeps account of splits and of what had to be fitted.
class AccountingWriter : public DatasetWriter {
 public:
  void add(const std::string& split, const LabeledScene& scene) final;
  WriteReport finish() final;

 protected:
  struct Form {
    SceneFrame frame = SceneFrame::kLidar;
    BoxForm boxes = BoxForm::kAny;
    /// The only classes; empty takes all.
    std::vector<std::string> classes = {};
  };

  AccountingWriter(Folder root, Form form) : root_(std::move(root)), form_(std::move(form)) {}
  const Folder& root() const { return root_; }
  const std::vector<std::string>& classes() const { return form_.classes; }
  std::size_t class_number(const LabeledObject& object) const;
  /// Splits with their names, sorted.
  std::vector<std::pair<std::string, std::vector<std::string>>> lists() const;
  /// Writes folder/PREFIX<split>SUFFIX with one name a line for each split.
  void write_lists(const Folder& folder, const std::string& prefix,
                   const std::string& suffix) const;

  /// Tells in the report that something changed, `what` in words that a count stands before.
  void note(const std::string& what, std::size_t count = 1);

  /// Writes a scene whose objects fit. May be called by several threads.
  virtual void write(const std::string& split, const LabeledScene& scene) = 0;
  virtual void write_rest() = 0;

 private:
  void enlist(const std::string& split, const std::string& name);
  LabeledScene fitted(const LabeledScene& scene);

  Folder root_;
  Form form_;
  mutable std::mutex mutex_;
  std::vector<std::pair<std::string, std::vector<std::string>>> lists_;
  std::set<std::string> seen_;
  WriteReport report_;
};

/// Makes a folder and those above it. Throws IoError.
void make_folder(const Folder& folder);

Reader open_arbox(const Folder& root, const DatasetOptions& options);
Reader open_kitti(const Folder& root, const DatasetOptions& options);
Reader open_scannet_raw(const Folder& root, const DatasetOptions& options);
Reader open_scannet_votenet(const Folder& root, const DatasetOptions& options);
Reader open_mmdet3d_scannet(const Folder& root, const DatasetOptions& options);
Reader open_sunrgbd(const Folder& root, const DatasetOptions& options);
Reader open_sunrgbd_votenet(const Folder& root, const DatasetOptions& options);
Reader open_mmdet3d_sunrgbd(const Folder& root, const DatasetOptions& options);
Reader open_sunrgbd_toolbox(const Folder& root, const DatasetOptions& options);
Reader open_cob3d(const Folder& root, const DatasetOptions& options);
Reader open_cob3d_v2(const Folder& root, const DatasetOptions& options);
Reader open_labelcloud(const Folder& root, const DatasetOptions& options);
Reader open_cvat(const Folder& root, const DatasetOptions& options);

bool fits_arbox(const Folder& root);
bool fits_kitti(const Folder& root);
bool fits_scannet_raw(const Folder& root);
bool fits_scannet_votenet(const Folder& root);
bool fits_mmdet3d_scannet(const Folder& root);
bool fits_sunrgbd(const Folder& root);
bool fits_sunrgbd_votenet(const Folder& root);
bool fits_mmdet3d_sunrgbd(const Folder& root);
bool fits_sunrgbd_toolbox(const Folder& root);
bool fits_cob3d(const Folder& root);
bool fits_cob3d_v2(const Folder& root);
bool fits_labelcloud(const Folder& root);
bool fits_cvat(const Folder& root);

/// What a writer is made with.
struct NewDataset {
  Folder root;
  SceneFrame frame;
  std::vector<std::string> classes;
  DatasetWriteOptions options;
};

Writer create_arbox(const NewDataset& dataset);
Writer create_kitti(const NewDataset& dataset);
Writer create_scannet_votenet(const NewDataset& dataset);
Writer create_sunrgbd(const NewDataset& dataset);
Writer create_sunrgbd_votenet(const NewDataset& dataset);
Writer create_sunrgbd_toolbox(const NewDataset& dataset);
Writer create_scannet_raw(const NewDataset& dataset);
Writer create_mmdet3d_scannet(const NewDataset& dataset);
Writer create_mmdet3d_sunrgbd(const NewDataset& dataset);
Writer create_cob3d(const NewDataset& dataset);
Writer create_cob3d_v2(const NewDataset& dataset);
Writer create_labelcloud(const NewDataset& dataset);
Writer create_cvat(const NewDataset& dataset);

}  // namespace arbox::io::internal
