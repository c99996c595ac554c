#include "arbox/detectors/open_detector.h"

#include <filesystem>

#include "arbox/base/error.h"
#include "arbox/base/plugin_loader.h"
#include "arbox/detectors/cluster_fit/cluster_fit.h"
#include "arbox/detectors/detector_kind.h"
#include "arbox/detectors/networks_library.h"
#include "arbox/io/model_search.h"

namespace arbox::detectors {
namespace {

namespace fs = std::filesystem;

using LoadModel = void(const std::string& file, const std::vector<std::string>& overrides,
                       std::unique_ptr<Detector>& result);

bool is_model_file(const std::string& name) {
  return name.find('/') != std::string::npos || name.ends_with(".arbox");
}

/// Empty if there is no such detector.
std::string unknown_detector(const std::string& name, Registry& registry) {
  try {
    require_plugin(DetectorKind::kName, name, registry);
    return {};
  } catch (const PluginError& error) {
    const fs::path file = "libarbox_detector_" + name + ".so";
    for (const fs::path& found : find_plugins()) {
      if (found.filename() == file) throw;
    }
    return error.what();
  }
}

std::unique_ptr<Detector> create_known(const std::string& name, const fs::path& configuration,
                                       const std::vector<std::string>& overrides,
                                       Registry& registry) {
  const OptionsInstance options = registry.find(DetectorKind::kName, name).options();
  if (!configuration.empty()) {
    assign_yaml(options.fields, read_options_file(configuration), configuration.string());
  }
  try {
    assign_overrides(options.fields, overrides);
  } catch (const ConfigError& error) {
    throw OverrideError(error.what());
  }
  return registry.create<DetectorKind>(name, options);
}

std::unique_ptr<Detector> open_model_file(const fs::path& file,
                                          const std::vector<std::string>& overrides) {
  static auto* const load = find_function<LoadModel>(kNetworksLibrary, "arbox_load_detector");
  std::unique_ptr<Detector> detector;
  try {
    load(file.string(), overrides, detector);
  } catch (const ConfigError& error) {
    throw OverrideError(file.string() + ": " + error.what());
  }
  return detector;
}

}  // namespace

Registry make_detector_registry() {
  Registry registry;
  registry.declare<DetectorKind>();
  registry.add_built_in(register_cluster_fit);
  return registry;
}

bool has_shipped_model() {
  try {
    io::find_model(kShippedModel);
  } catch (const IoError&) {
    return false;
  }
  return is_installed(kNetworksLibrary);
}

std::unique_ptr<Detector> create_detector(const std::string& name, const fs::path& configuration,
                                          const std::vector<std::string>& overrides,
                                          Registry& registry) {
  const std::string unknown = unknown_detector(name, registry);
  if (!unknown.empty()) throw InvalidArgument(unknown);
  return create_known(name, configuration, overrides, registry);
}

std::unique_ptr<Detector> open_model(const std::string& name,
                                     const std::vector<std::string>& overrides) {
  return open_model_file(io::find_model(name), overrides);
}

std::unique_ptr<Detector> open_detector(const std::string& name,
                                        const std::vector<std::string>& overrides,
                                        Registry& registry) {
  if (is_model_file(name)) return open_model(name, overrides);
  const std::string unknown = unknown_detector(name, registry);
  if (unknown.empty()) return create_known(name, {}, overrides, registry);
  fs::path file;
  try {
    file = io::find_model(name);
  } catch (const IoError& error) {
    throw InvalidArgument(unknown + "; " + error.what());
  }
  return open_model_file(file, overrides);
}

std::unique_ptr<Detector> open_detector(const std::string& name,
                                        const std::vector<std::string>& overrides) {
  Registry registry = make_detector_registry();
  return open_detector(name, overrides, registry);
}

}  // namespace arbox::detectors
