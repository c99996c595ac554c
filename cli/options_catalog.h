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

/// A name that find_options knows.
struct CatalogName {
  std::string name;
  std::string help;
};

/// Every options struct that describes itself: those of full_program_registry() as "KIND/NAME", and
/// those of the library that are listed in options_catalog.cpp, where a new one is added. Opens no
/// LibTorch: what needs it is listed there by name, too.
std::vector<CatalogName> options_names();

/// Throws UsageError that names the nearest for an unknown name. Opens LibTorch where the struct
/// belongs to something that needs it.
CatalogEntry find_options(std::string_view name);

}  // namespace arbox::cli
