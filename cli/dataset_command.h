#pragma once

#include <CLI/App.hpp>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "arbox/io/dataset.h"

/// \file
/// What the commands do with folders of labelled scans.

namespace arbox::cli {

/// Adds the flags of io::DatasetOptions and --split to a command.
void add_dataset_flags(CLI::App& command, io::DatasetOptions& options,
                       std::vector<std::string>& splits);

struct DatasetInfoFlags {
  std::filesystem::path root;
  io::DatasetOptions options;
  std::vector<std::string> splits;
  bool json = false;
};

/// Checks a dataset and prints what it holds and what is wrong with it (`arbox info DATASET`).
void info_dataset(const DatasetInfoFlags& flags);

struct DatasetConvertFlags {
  std::filesystem::path input, output;
  io::DatasetOptions options;
  std::vector<std::string> splits;
  std::string layout = "arbox";
  io::DatasetWriteOptions write = {};
  /// FROM=TO; nothing after the sign leaves the class out.
  std::vector<std::string> class_map;
  bool skip_broken = false;
  bool json = false;
};

/// Writes a dataset in another layout (`arbox convert DATASET DATASET`).
void convert_dataset(const DatasetConvertFlags& flags);

/// A scene of a dataset: that of the name, or the first one of its last split, which holds all.
/// Throws UsageError for a name that no split has.
io::LabeledScene find_scene(const io::DatasetReader& dataset, const std::string& name);

}  // namespace arbox::cli
