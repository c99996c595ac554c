#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "arbox/base/registry.h"
#include "arbox/geometry/box.h"

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

/// The functions of the library.
struct TorchModule {
  /// Declares the kinds that pass tensors and adds what is built in of them.
  void (*register_built_ins)(Registry& registry);
  /// Makes heads::CodecOptions.
  OptionsMaker codec_options;
  FitBinsResult (*fit_bins)(const FitBinsRequest& request);
};

/// Opens the library, once. Throws NotAvailable if this installation lacks it.
const TorchModule& torch_module();

/// Whether the installation has the library.
bool has_torch_module();

}  // namespace arbox::cli
