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

/// Every options struct of the library that describes itself, in alphabetical order of names.
/// A new options struct is added to the list in options_catalog.cpp.
const std::vector<CatalogEntry>& options_catalog();

/// Throws UsageError that names the nearest for an unknown name.
const CatalogEntry& find_options(std::string_view name);

}  // namespace arbox::cli
