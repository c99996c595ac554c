#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "arbox/detectors/model_file.h"
#include "arbox/detectors/pv_rcnn/network.h"
#include "arbox/detectors/pv_rcnn/pv_rcnn.h"
#include "arbox/evaluation/confidence_calibration.h"

/// \file
/// PV-RCNN as a model file (io/model_archive.h): kind "pv_rcnn", the options as its configuration,
/// parameters and buffers under the network's names, the head's under roi_head.box_head.

namespace arbox::detectors::pv_rcnn {

/// What a file tells beside the network.
struct ModelNotes {
  /// For people, Markdown.
  std::string card = {};
  /// Objects that confidence boxes are calibrated on.
  std::optional<evaluation::ConfidenceCalibration> calibration = {};
};

struct Model {
  /// In eval mode.
  std::shared_ptr<Network> network;
  ModelNotes notes = {};
};

/// A file's content with `head` in place of the network's own; `options` name it. Children
/// box_heads of the network, further heads in training, are left out.
io::ModelArchive to_archive(const Network& network, const heads::BoxHead& head,
                            const Options& options, const ModelNotes& notes = {},
                            WeightPrecision precision = WeightPrecision::kFull);

/// Writes a network with its own head. Throws IoError.
void save_model(const std::filesystem::path& path, Network& network, const ModelNotes& notes = {},
                WeightPrecision precision = WeightPrecision::kFull);

/// The model of an archive; `source` begins messages. Throws FormatError for another kind of file,
/// class names that differ from the configuration's, records that do not fit the network (all of
/// them in one message) and a broken calibration; ConfigError for the configuration; PluginError
/// for a head that is not there.
Model to_model(const io::ModelArchive& archive, const std::string& source);

/// Throws IoError too.
Model load_model(const std::filesystem::path& path);

/// The detector of a model file, with its calibration. Throws as load_model.
std::unique_ptr<PvRcnn> load_pv_rcnn(const std::filesystem::path& path);

}  // namespace arbox::detectors::pv_rcnn
