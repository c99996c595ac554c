#include "arbox/cli/options_catalog.h"

#include "arbox/base/names.h"
#include "arbox/cli/command_line.h"
#include "arbox/cli/program_registry.h"
#include "arbox/drawing/scene.h"
#include "arbox/geometry/nms.h"
#include "arbox/geometry/quantile_box.h"
#include "arbox/io/point_cloud_file.h"
#include "arbox/simulation/street_stream.h"

namespace arbox::cli {

std::vector<CatalogEntry> options_catalog() {
  std::vector<CatalogEntry> catalog = {
      {"nms", "Non-maximum suppression", &make_options<geometry::NmsOptions>},
      {"quantile_box", "Quantile boxes of box samples", &make_options<geometry::QuantileOptions>},
      {"read_cloud", "How a point cloud is read", &make_options<io::ReadOptions>},
      {"scene", "How a scene is drawn", &make_options<drawing::SceneOptions>},
      {"street_scan", "How streets are simulated", &make_options<simulation::StreetScanOptions>},
      {"write_cloud", "How a point cloud is written", &make_options<io::WriteOptions>},
  };
  for (const RegistryEntry& entry : program_registry().entries()) {
    catalog.push_back({entry.kind + "/" + entry.name, entry.help, entry.options});
  }
  return catalog;
}

CatalogEntry find_options(std::string_view name) {
  std::vector<std::string> names;
  for (const CatalogEntry& entry : options_catalog()) {
    if (entry.name == name) return entry;
    names.push_back(entry.name);
  }
  throw UsageError(unknown_name_text("options", name, names));
}

}  // namespace arbox::cli
