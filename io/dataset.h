#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "arbox/io/labeled_scene.h"

/// \file
/// Datasets of any layout behind one interface (docs/datasets/README.md):
///
///     const auto dataset = io::open_dataset("scannet");
///     for (const std::string& name : dataset->names("val")) {
///       const io::LabeledScene scene = dataset->load("val", name);
///     }

namespace arbox::io {

/// A folder of labelled scenes. Reading is thread-safe: nothing changes after opening.
class DatasetReader {
 public:
  virtual ~DatasetReader();

  /// The name of its layout: one of dataset_layouts().
  virtual std::string_view layout() const = 0;
  /// The frame that all its scenes come in.
  virtual SceneFrame frame() const = 0;
  /// Its classes in its own order; empty if it has no fixed list.
  virtual std::vector<std::string> classes() const = 0;
  /// Names of the splits. The last one, "all" where the dataset itself has no such split, holds
  /// every scene.
  virtual std::vector<std::string> splits() const = 0;
  /// Names of the scenes of a split, in its order. Throws InvalidArgument, with the splits that
  /// there are, for an unknown one, FormatError for a bad list.
  virtual std::vector<std::string> names(std::string_view split) const = 0;
  /// Reads a scene. Throws IoError, FormatError that name the file.
  virtual LabeledScene load(std::string_view split, std::string_view name) const = 0;
  /// What is wrong with the folder as a whole, one line each: labels without a scan, unknown files
  /// in lists.
  virtual std::vector<std::string> problems() const { return {}; }
};

/// What a folder cannot tell itself.
struct DatasetOptions {
  /// Which layout; empty looks at the folder.
  std::string layout = "";
  /// Which labels of SUN RGB-D's extraction: "v2" (folder label) or "v1" (label_v1).
  std::string sunrgbd_labels = "v2";
  /// Sense of yaw in mmdetection3d's files of SUN RGB-D: "clockwise" (before 1.0),
  /// "counter-clockwise" (from 1.0 on), or empty to find out (docs/datasets/sunrgbd.md).
  std::string yaw = "";
  /// Unit of labelCloud's angles: "degrees" (centroid_abs), "radians" (centroid_rel), or empty to
  /// find out.
  std::string angles = "";
  /// Classes that SUN RGB-D's extraction and ScanNet's raw release keep: "benchmark" (10 and 18) or
  /// "all".
  std::string classes = "benchmark";

  template <class Visitor>
  static void describe(Visitor& visitor) {
    visitor.field("layout", &DatasetOptions::layout,
                  {.help = "Layout of the dataset; empty looks at the folder",
                   .choices = {"", "arbox", "kitti", "scannet", "scannet-votenet",
                               "scannet-mmdet3d", "sunrgbd", "sunrgbd-votenet", "sunrgbd-mmdet3d",
                               "sunrgbd-toolbox", "cob3d", "cob3d-v2", "labelcloud", "cvat"}});
    visitor.field(
        "sunrgbd_labels", &DatasetOptions::sunrgbd_labels,
        {.help = "Which labels of SUN RGB-D's extraction are read", .choices = {"v1", "v2"}});
    visitor.field("yaw", &DatasetOptions::yaw,
                  {.help = "Sense of yaw in mmdetection3d's files of SUN RGB-D; empty finds out",
                   .choices = {"", "clockwise", "counter-clockwise"}});
    visitor.field("angles", &DatasetOptions::angles,
                  {.help = "Unit of the angles of labelCloud's files; empty finds out",
                   .choices = {"", "degrees", "radians"}});
    visitor.field("classes", &DatasetOptions::classes,
                  {.help = "Objects of SUN RGB-D and ScanNet that are kept: those of the "
                           "benchmark's classes, or all",
                   .choices = {"benchmark", "all"}});
  }
};

/// Names of the layouts; each is read and written.
std::vector<std::string> dataset_layouts();

/// The layout that a folder has the files of. Throws IoError for what is no folder and FormatError,
/// saying what each layout looks like, for a folder that fits none.
std::string guess_layout(const std::filesystem::path& root);

/// Opens a folder. Throws as guess_layout, IoError for missing parts, ConfigError for bad options.
std::unique_ptr<DatasetReader> open_dataset(const std::filesystem::path& root,
                                            const DatasetOptions& options = {});

/// What a layout could not hold as it was.
struct WriteReport {
  std::size_t scenes = 0, objects = 0;
  /// Objects of classes that the layout has no number for, left out, by class.
  std::map<std::string, std::size_t> left_out = {};
  /// Boxes that stand for a tilted or turned one, which they enclose.
  std::size_t enclosed = 0;
  /// What else changed, in words, and how often.
  std::map<std::string, std::size_t> notes = {};
};

/// What a writer is asked for beyond the layout.
struct DatasetWriteOptions {
  /// Which mmdetection3d the infos of scannet-mmdet3d and sunrgbd-mmdet3d are for: "1.1" and later
  /// (plain lists), "1.0" (NumPy arrays), "0.x" (the same, yaw of SUN RGB-D clockwise).
  std::string infos = "1.1";

  template <class Visitor>
  static void describe(Visitor& visitor) {
    visitor.field("infos", &DatasetWriteOptions::infos,
                  {.help = "Version of mmdetection3d that written infos are for",
                   .choices = {"1.1", "1.0", "0.x"}});
  }
};

/// Writes scenes in a dataset's layout. Objects that it cannot hold are fitted to it: in layouts of
/// upright boxes a tilted box becomes the smallest upright one around it with the heading of its
/// x axis, in layouts without rotation a turned one becomes its axis-aligned hull; objects of
/// classes that the layout has no number for are left out. WriteReport counts them. What each
/// layout cannot hold: docs/datasets/README.md.
class DatasetWriter {
 public:
  virtual ~DatasetWriter();
  /// Adds a scene, which is brought into the dataset's frame, to a split. Throws InvalidArgument
  /// for a name that came before or cannot be a file's, and for invalid boxes, naming scene and
  /// object; IoError. Thread-safe.
  virtual void add(const std::string& split, const LabeledScene& scene) = 0;
  /// Writes what stands once for all scenes (split lists, infos). Called once, after the last add.
  virtual WriteReport finish() = 0;
};

/// Makes the folder if it is not there. `frame` and `classes` are those of the scenes that will
/// come, for layouts that can have any. All layouts that are read are written. Throws
/// InvalidArgument for an unknown layout, ConfigError for bad options, IoError for a folder that is
/// not empty.
std::unique_ptr<DatasetWriter> create_dataset(const std::filesystem::path& root,
                                              const std::string& layout,
                                              SceneFrame frame = SceneFrame::kLidar,
                                              const std::vector<std::string>& classes = {},
                                              const DatasetWriteOptions& options = {});

}  // namespace arbox::io
