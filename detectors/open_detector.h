#pragma once

#include <memory>
#include <string>
#include <vector>

#include "arbox/base/registry.h"
#include "arbox/detectors/detector.h"

/// \file
/// Detectors by name, for programs that let their user choose one. LibTorch is loaded when a model
/// is opened and not before.

namespace arbox::detectors {

/// A registry that knows the kind `detector` and the built-in `cluster_fit`.
Registry make_detector_registry();

/// Opens what `name` names: the first of
///
/// - a model file, if it has a '/' or ends in ".arbox";
/// - a detector of the registry, or of a plugin (base/plugin_loader.h);
/// - a model NAME.arbox in io::model_folders().
///
/// `overrides` are changes to its options, each KEY=VALUE. Throws IoError for a missing model file,
/// InvalidArgument that lists detectors and models for an unknown name, ConfigError for overrides,
/// FormatError for broken models, NotAvailable if this installation has no networks.
std::unique_ptr<Detector> open_detector(const std::string& name,
                                        const std::vector<std::string>& overrides = {});
std::unique_ptr<Detector> open_detector(const std::string& name,
                                        const std::vector<std::string>& overrides,
                                        Registry& registry);

}  // namespace arbox::detectors
