#include "arbox/cli/options_catalog.h"

#include <algorithm>

#include "arbox/base/names.h"
#include "arbox/cli/command_line.h"

namespace arbox::cli {

const std::vector<CatalogEntry>& options_catalog() {
  static const std::vector<CatalogEntry> catalog = {};
  return catalog;
}

const CatalogEntry& find_options(std::string_view name) {
  const std::vector<CatalogEntry>& catalog = options_catalog();
  std::vector<std::string> names;
  for (const CatalogEntry& entry : catalog) {
    if (entry.name == name) return entry;
    names.push_back(entry.name);
  }
  throw UsageError(unknown_name_text("options", name, names));
}

}  // namespace arbox::cli
