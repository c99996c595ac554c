#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "arbox/base/options.h"

namespace arbox::cli {

/// One options struct that `arbox config` knows.
struct CatalogEntry {
  std::string name;
  std::string help;
  OptionsMaker make;
};

/// Every options struct that describes itself: those of program_registry() as "KIND/NAME", and
/// those of the library that are listed in options_catalog.cpp, where a new one is added.
std::vector<CatalogEntry> options_catalog();

/// Throws UsageError that names the nearest for an unknown name.
CatalogEntry find_options(std::string_view name);

}  // namespace arbox::cli
