#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "arbox/detectors/pv_rcnn/model.h"

namespace arbox::detectors::pv_rcnn {

/// How a checkpoint lays out the weights of sparse convolutions.
enum class SparseLayout {
  /// The one that all shapes fit.
  kAutomatic,
  /// spconv 1: (z, y, x, in, out).
  kSpconv1,
  /// spconv 2: (out, z, y, x, in), as Arbox does.
  kSpconv2,
  /// Builds of spconv 2 without implicit convolution: (z, y, x, out, in).
  kSpconv2Native
};

struct ImportOptions {
  /// The network that was trained; if absent, KITTI's at the size of the paper, with the
  /// autoregressive head of its authors' checkpoints if the checkpoint has `roi_head.autoreg`, else
  /// with the pointwise one.
  std::optional<Options> network = {};
  /// Changes to it, each KEY=VALUE.
  std::vector<std::string> overrides = {};
  SparseLayout layout = SparseLayout::kAutomatic;

  template <class Visitor>
  static void describe(Visitor& visitor) {
    visitor.field("layout", &ImportOptions::layout,
                  {.help = "Layout of the weights of sparse convolutions, if shapes do not tell",
                   .choices = {"automatic", "spconv1", "spconv2", "spconv2_native"}});
  }
};

struct ImportReport {
  SparseLayout layout = SparseLayout::kSpconv2;
  /// Arrays and numbers that the network took.
  std::int64_t entries = 0, parameters = 0;
  /// Entries of the checkpoint that the network has no place for; "a.b.* (4)" for all of a part.
  std::vector<std::string> unused;
};

struct Import {
  Model model;
  ImportReport report;
};

/// The network of an OpenPCDet checkpoint (.pth): its `model_state`, or a dictionary of tensors.
/// Nothing of the file is run (io/torch_checkpoint.h). `global_step` is passed over, missing
/// num_batches_tracked count as 0, a prefix `module.` of all names is taken off. Throws IoError;
/// FormatError that lists all entries that are missing, whose shape differs and that are unused,
/// where one is missing or differs; as to_model().
Import import_openpcdet(const std::filesystem::path& checkpoint, const ImportOptions& options = {});

/// The authors' network of Liu et al., ECCV 2022: centre before size before heading, end bins of
/// headings kept apart.
Options autoregressive_reference_options();

}  // namespace arbox::detectors::pv_rcnn
