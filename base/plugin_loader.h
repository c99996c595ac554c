#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "arbox/base/registry.h"

/// \file
/// Plugins: shared libraries `libarbox_<kind>_<name>.so` (base/plugin.h tells how to write one).
///
/// A library is opened with RTLD_NOW | RTLD_LOCAL and never closed. Opening runs its static
/// initialisers, so open only files that you trust. They are looked for in the folders of
/// ARBOX_PLUGIN_PATH, then in the installation, never in the working directory.

namespace arbox {

struct PluginDescription {
  std::filesystem::path file;
  std::string kind;
  std::string name;
  std::string version;
  std::string licence;
};

/// Opens a library and compares its ABI number, kind, file name and build fingerprint with this
/// process, without running its C++. Throws PluginError that names the file and each difference
/// with both values.
PluginDescription inspect_plugin(const std::filesystem::path& file, const Registry& registry);

/// inspect_plugin, then registers what it brings; nothing if that fails. A file whose entry is
/// already registered from the same file is left as it is. Throws PluginError.
PluginDescription load_plugin(const std::filesystem::path& file, Registry& registry);

/// Loads the first file that is found for a name, unless the registry knows the name. Unknown names
/// throw PluginError that lists the names that are registered or found, and the nearest.
void require_plugin(std::string_view kind, std::string_view name, Registry& registry);

/// The folders of ARBOX_PLUGIN_PATH (separated by colons), then the installation's. Throws
/// ConfigError for a folder that is not absolute.
std::vector<std::filesystem::path> plugin_folders();

/// Files in plugin_folders() whose name is that of a plugin, by folder, then by name.
std::vector<std::filesystem::path> find_plugins();

}  // namespace arbox
