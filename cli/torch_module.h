#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "arbox/base/registry.h"
#include "arbox/geometry/box.h"
#include "arbox/training/train_report.h"

/// \file
/// What the program does with LibTorch lives in a library of its own that is opened when it is
/// first needed: loading LibTorch takes longer than most commands run.

namespace arbox::cli {

/// Ranges of bins for the boxes of a data set (heads/fit_ranges.h).
struct FitBinsRequest {
  std::vector<geometry::Box> boxes;
  /// KEY=VALUE changes to heads::CodecOptions.
  std::vector<std::string> codec;
  int draws = 1;
  std::uint64_t seed = 0;
};

struct FitBinsResult {
  /// The codec's options as YAML.
  std::string codec;
  double mean_iou = 0.0;
  double overflow = 0.0;
  bool reached = false;
};

/// A checkpoint of another program as a model (detectors/pv_rcnn/import_openpcdet.h).
struct ImportRequest {
  std::string checkpoint, output;
  /// YAML file of the network's options; empty for what the checkpoint tells.
  std::string configuration;
  /// KEY=VALUE changes to the network's options.
  std::vector<std::string> overrides;
  /// layout=NAME.
  std::vector<std::string> options;
  /// Write weights as float16.
  bool half = false;
};

struct ImportResult {
  std::string head, layout;
  std::vector<std::string> classes;
  std::int64_t entries = 0, parameters = 0;
  std::vector<std::string> unused;
};

/// A head of a model file.
struct ModelHead {
  std::string name;
  /// False for heads that answer with one box and nothing else.
  bool has_distribution = true;
};

/// A model written anew.
struct PackRequest {
  /// A model file, or the folder of a training run.
  std::string model;
  std::string output;
  /// A model whose weights the result's move towards, and how far; empty for none. Parts in
  /// `average_except` keep theirs and need not be there.
  std::string average;
  double share = 0.5;
  std::vector<std::string> average_except;
  /// In place of the model's own card, if not empty.
  std::string card;
  /// KEY=VALUE changes to the network's options.
  std::vector<std::string> overrides;
  /// Write weights as float16.
  bool half = false;
};

/// A run of training/train.h with a configuration of training/pv_rcnn_training.h.
struct TrainRequest {
  std::filesystem::path folder;
  /// A YAML file.
  std::filesystem::path configuration;
  /// KEY=VALUE changes to it.
  std::vector<std::string> overrides;
  bool resume = false;
  training::TrainObserver* observer = nullptr;
};

struct TrainOutcome {
  /// False in the helping processes of a data-parallel run.
  bool leads = true;
  /// False if the run was asked to end before, or its time was over.
  bool finished = false;
  std::int64_t steps = 0;
  std::int64_t skipped = 0;
};

/// Options structs of the library beside those of what it registers.
struct TorchOptions {
  const char* name;
  const char* help;
};
inline constexpr std::array<TorchOptions, 3> kTorchOptions = {
    {{"codec", "How heads turn boxes into numbers"},
     {"conditioning", "How boxes of known sizes are searched and compared"},
     {"train/pv_rcnn", "A training run of PV-RCNN"}}};

/// The functions of the library.
struct TorchModule {
  /// Declares the kinds that pass tensors and adds what is built in of them.
  void (*register_built_ins)(Registry& registry);
  /// What makes the options struct of a name of kTorchOptions; null for any other name.
  OptionsMaker (*find_options)(std::string_view name);
  FitBinsResult (*fit_bins)(const FitBinsRequest& request);
  ImportResult (*import_openpcdet)(const ImportRequest& request);
  TrainOutcome (*train)(const TrainRequest& request);
  /// The heads of a model file, the one that answers first.
  std::vector<ModelHead> (*model_heads)(const std::string& file);
  /// Keeps the card, unless another is given, and the calibration, unless weights change.
  void (*pack)(const PackRequest& request);
};

/// Opens the library, once. Throws NotAvailable if this installation lacks it.
const TorchModule& torch_module();

/// Whether the installation has the library.
bool has_torch_module();

}  // namespace arbox::cli
