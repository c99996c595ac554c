#include "arbox/cli/options_catalog.h"

#include <algorithm>
#include <optional>

#include "arbox/base/names.h"
#include "arbox/base/plugin_loader.h"
#include "arbox/cli/command_line.h"
#include "arbox/cli/program_registry.h"
#include "arbox/cli/torch_module.h"
#include "arbox/drawing/scene.h"
#include "arbox/geometry/nms.h"
#include "arbox/geometry/quantile_box.h"
#include "arbox/heads/built_in_heads.h"
#include "arbox/io/point_cloud_file.h"
#include "arbox/simulation/street_dataset.h"

namespace arbox::cli {

namespace {

using Catalog = std::vector<CatalogEntry>;

Catalog library_catalog() {
  return {
      {"nms", "Non-maximum suppression", &make_options<geometry::NmsOptions>},
      {"quantile_box", "Quantile boxes of box samples", &make_options<geometry::QuantileOptions>},
      {"read_cloud", "How a point cloud is read", &make_options<io::ReadOptions>},
      {"scene", "How a scene is drawn", &make_options<drawing::SceneOptions>},
      {"street_dataset", "What arbox simulate street writes",
       &make_options<simulation::StreetDatasetOptions>},
      {"street_scan", "How streets are simulated", &make_options<simulation::StreetScanOptions>},
      {"write_cloud", "How a point cloud is written", &make_options<io::WriteOptions>},
  };
}

Catalog registry_catalog(const Registry& registry) {
  Catalog catalog;
  for (const RegistryEntry& entry : registry.entries()) {
    catalog.push_back({entry.kind + "/" + entry.name, entry.help, entry.options});
  }
  return catalog;
}

std::optional<CatalogEntry> find_in(const Catalog& catalog, std::string_view name) {
  for (const CatalogEntry& entry : catalog) {
    if (entry.name == name) return entry;
  }
  return std::nullopt;
}

/// What the plugin of that name brings, if there is one in the folders of plugins.
std::optional<CatalogEntry> find_in_plugins(std::string_view name) {
  const std::size_t slash = name.find('/');
  if (slash == std::string_view::npos) return std::nullopt;
  const std::string wanted = "libarbox_" + std::string(name.substr(0, slash)) + "_" +
                             std::string(name.substr(slash + 1)) + ".so";
  for (const auto& file : find_plugins()) {
    if (file.filename() != wanted) continue;
    Registry& registry = full_program_registry();
    load_plugin(file, registry);
    return find_in(registry_catalog(registry), name);
  }
  return std::nullopt;
}

}  // namespace

std::vector<CatalogName> options_names() {
  std::vector<CatalogName> names;
  const auto add = [&](const CatalogName& name) {
    const bool known = std::any_of(names.begin(), names.end(),
                                   [&](const auto& other) { return other.name == name.name; });
    if (!known) names.push_back(name);
  };
  for (const CatalogEntry& entry : library_catalog()) add({entry.name, entry.help});
  for (const CatalogEntry& entry : registry_catalog(program_registry())) {
    add({entry.name, entry.help});
  }
  if (!has_torch_module()) return names;
  for (const TorchOptions& options : kTorchOptions) add({options.name, options.help});
  for (const heads::BuiltInHead& head : heads::kBuiltInHeads) {
    add({std::string("head/") + head.name, head.help});
  }
  return names;
}

CatalogEntry find_options(std::string_view name) {
  if (const auto entry = find_in(library_catalog(), name)) return *entry;
  if (const auto entry = find_in(registry_catalog(program_registry()), name)) return *entry;
  for (const TorchOptions& options : kTorchOptions) {
    if (name == options.name && has_torch_module()) {
      return {options.name, options.help, torch_module().find_options(name)};
    }
  }
  if (const auto entry = find_in(registry_catalog(full_program_registry()), name)) return *entry;
  if (const auto entry = find_in_plugins(name)) return *entry;
  std::vector<std::string> names;
  for (const CatalogName& known : options_names()) names.push_back(known.name);
  throw UsageError(unknown_name_text("options", name, names));
}

}  // namespace arbox::cli
