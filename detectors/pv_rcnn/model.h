#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "arbox/detectors/model_file.h"
#include "arbox/detectors/pv_rcnn/network.h"
#include "arbox/detectors/pv_rcnn/pv_rcnn.h"
#include "arbox/evaluation/confidence_calibration.h"

/// \file
/// PV-RCNN as a model file (io/model_archive.h): kind "pv_rcnn", the options as its configuration,
/// parameters and buffers of the network with all its heads under the network's names.

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

/// Writes a network with all its heads; with kHalf the file is compressed, too. Throws IoError.
void save_model(const std::filesystem::path& path, const Network& network,
                const ModelNotes& notes = {}, WeightPrecision precision = WeightPrecision::kFull);

/// The model of an archive; `source` begins messages. Throws FormatError for another kind of file,
/// class names that differ from the configuration's, records that do not fit the network (all of
/// them in one message) and a broken calibration; ConfigError for the configuration; PluginError
/// for a head that is not there. `overrides`: changes to the configuration, each KEY=VALUE.
Model to_model(const io::ModelArchive& archive, const std::string& source,
               const std::vector<std::string>& overrides = {});

/// Throws IoError too.
Model load_model(const std::filesystem::path& path, const std::vector<std::string>& overrides = {});

/// The detector of a model file, with its calibration. Throws as load_model.
std::unique_ptr<PvRcnn> load_pv_rcnn(const std::filesystem::path& path,
                                     const std::vector<std::string>& overrides = {});

}  // namespace arbox::detectors::pv_rcnn
