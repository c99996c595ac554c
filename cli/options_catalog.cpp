#include "arbox/cli/options_catalog.h"

#include "arbox/base/names.h"
#include "arbox/cli/command_line.h"
#include "arbox/cli/program_registry.h"
#include "arbox/cli/torch_module.h"
#include "arbox/drawing/scene.h"
#include "arbox/geometry/nms.h"
#include "arbox/geometry/quantile_box.h"
#include "arbox/io/point_cloud_file.h"
#include "arbox/simulation/street_stream.h"

namespace arbox::cli {

namespace {

void add_entries(const Registry& registry, std::vector<CatalogEntry>& catalog) {
  for (const RegistryEntry& entry : registry.entries()) {
    catalog.push_back({entry.kind + "/" + entry.name, entry.help, entry.options});
  }
}

/// What needs no LibTorch.
std::vector<CatalogEntry> quick_catalog() {
  std::vector<CatalogEntry> catalog = {
      {"nms", "Non-maximum suppression", &make_options<geometry::NmsOptions>},
      {"quantile_box", "Quantile boxes of box samples", &make_options<geometry::QuantileOptions>},
      {"read_cloud", "How a point cloud is read", &make_options<io::ReadOptions>},
      {"scene", "How a scene is drawn", &make_options<drawing::SceneOptions>},
      {"street_scan", "How streets are simulated", &make_options<simulation::StreetScanOptions>},
      {"write_cloud", "How a point cloud is written", &make_options<io::WriteOptions>},
  };
  return catalog;
}

}  // namespace

std::vector<CatalogEntry> options_catalog() {
  std::vector<CatalogEntry> catalog = quick_catalog();
  if (has_torch_module()) {
    catalog.push_back({"codec", "How heads turn boxes into numbers", torch_module().codec_options});
  }
  add_entries(full_program_registry(), catalog);
  return catalog;
}

CatalogEntry find_options(std::string_view name) {
  std::vector<CatalogEntry> quick = quick_catalog();
  add_entries(program_registry(), quick);
  for (const CatalogEntry& entry : quick) {
    if (entry.name == name) return entry;
  }
  std::vector<std::string> names;
  for (const CatalogEntry& entry : options_catalog()) {
    if (entry.name == name) return entry;
    names.push_back(entry.name);
  }
  throw UsageError(unknown_name_text("options", name, names));
}

}  // namespace arbox::cli
