#include "arbox/cli/options_catalog.h"

#include "arbox/base/names.h"
#include "arbox/cli/command_line.h"
#include "arbox/cli/program_registry.h"
#include "arbox/drawing/scene.h"

namespace arbox::cli {

std::vector<CatalogEntry> options_catalog() {
  std::vector<CatalogEntry> catalog = {
      {"scene", "Pictures of scans with boxes", make_options<drawing::SceneOptions>},
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
