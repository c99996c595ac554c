#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "arbox/base/error.h"
#include "arbox/base/registry.h"
#include "arbox/detectors/detector.h"

/// \file
/// Detectors by name, for programs that let their user choose one. LibTorch is loaded when a model
/// is opened and not before.

namespace arbox::detectors {

/// A registry that knows the kind `detector` and the built-in `cluster_fit`.
Registry make_detector_registry();

/// The model that comes with Arbox.
inline constexpr char kShippedModel[] = "pv_rcnn_compact";

/// Whether it is found (io/model_search.h), and the installation has networks. Throws as
/// io::model_folders.
bool has_shipped_model();

/// Changes to options, each KEY=VALUE, that do not fit them.
class OverrideError : public ConfigError {
 public:
  using ConfigError::ConfigError;
};

/// A detector of the registry, or of a plugin (base/plugin_loader.h), which is brought into it.
/// `configuration` is a YAML file of its options, empty for none; `overrides` come after it. Throws
/// InvalidArgument that lists detectors for an unknown name, PluginError, IoError and ConfigError
/// for the file, OverrideError.
std::unique_ptr<Detector> create_detector(const std::string& name,
                                          const std::filesystem::path& configuration,
                                          const std::vector<std::string>& overrides,
                                          Registry& registry);

/// The detector of a model, a file or a name (io/model_search.h). `overrides` are changes to its
/// options. Throws IoError for one that is not there, OverrideError, FormatError for broken models,
/// NotAvailable if this installation has no networks.
std::unique_ptr<Detector> open_model(const std::string& name,
                                     const std::vector<std::string>& overrides = {});

/// Opens what `name` names: the first of
///
/// - a model file, if it has a '/' or ends in ".arbox";
/// - a detector of the registry, or of a plugin (base/plugin_loader.h);
/// - a model NAME.arbox in io::model_folders().
///
/// Throws as create_detector and open_model; InvalidArgument that lists detectors and models for a
/// name that nobody knows.
std::unique_ptr<Detector> open_detector(const std::string& name,
                                        const std::vector<std::string>& overrides = {});
std::unique_ptr<Detector> open_detector(const std::string& name,
                                        const std::vector<std::string>& overrides,
                                        Registry& registry);

}  // namespace arbox::detectors
