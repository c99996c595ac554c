#include "arbox/base/plugin_loader.h"

#include <algorithm>
#include <boost/dll/runtime_symbol_info.hpp>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <sstream>

#include "arbox/base/error.h"
#include "arbox/base/internal/open_forever.h"
#include "arbox/base/names.h"
#include "arbox/base/plugin_abi.h"

namespace arbox {
namespace {

namespace fs = std::filesystem;
using InfoFunction = const ArboxPluginInfo*();
using RegisterFunction = void(Registrar&);

constexpr std::string_view kPrefix = "libarbox_";
constexpr std::string_view kSuffix = ".so";

struct OpenPlugin {
  PluginDescription description;
  RegisterFunction* register_function;
};

boost::dll::shared_library open(const fs::path& file) {
  if (!fs::is_regular_file(file)) throw PluginError(file.string() + ": no such file");
  try {
    return internal::open_forever(file);
  } catch (const std::exception& error) {
    throw PluginError(file.string() + ": cannot be loaded: " + error.what());
  }
}

template <class Function>
Function* symbol(const boost::dll::shared_library& library, const char* name,
                 const fs::path& file) {
  if (!library.has(name)) {
    throw PluginError(file.string() + ": has no function '" + name +
                      "', expected the two that ARBOX_PLUGIN exports");
  }
  return &library.get<Function>(name);
}

std::string text_of(const char* text) { return text == nullptr ? "" : text; }

class Comparison {
 public:
  void text(std::string_view what, const char* plugin, std::string_view host) {
    if (text_of(plugin) != host) {
      differ(what, "'" + text_of(plugin) + "'", "'" + std::string(host) + "'");
    }
  }
  void number(std::string_view what, std::uint32_t plugin, std::uint32_t host) {
    if (plugin != host) differ(what, std::to_string(plugin), std::to_string(host));
  }
  void finish(const fs::path& file) const {
    if (differences_.empty()) return;
    throw PluginError(file.string() + ": does not fit this build: " + join(differences_, "; "));
  }

 private:
  void differ(std::string_view what, const std::string& plugin, const std::string& host) {
    differences_.push_back(std::string(what) + ": the plugin has " + plugin + ", Arbox has " +
                           host);
  }
  std::vector<std::string> differences_;
};

void compare_layout(const ArboxPluginInfo& info, const fs::path& file) {
  Comparison comparison;
  comparison.number("plugin ABI", info.abi, kPluginAbi);
  comparison.number("size of ArboxPluginInfo", info.struct_size, sizeof(ArboxPluginInfo));
  comparison.finish(file);
}

void compare_build(const ArboxBuildFingerprint& plugin, const std::string& libtorch,
                   const fs::path& file) {
  constexpr ArboxBuildFingerprint kHost = build_fingerprint();
  Comparison comparison;
  comparison.text("compiler", plugin.compiler, kHost.compiler);
  comparison.text("standard library", plugin.standard_library, kHost.standard_library);
  comparison.number("C++ standard", plugin.cpp_standard, kHost.cpp_standard);
  comparison.text("LibTorch", plugin.libtorch, libtorch);
  comparison.number("EIGEN_MAX_ALIGN_BYTES", plugin.eigen_max_align_bytes,
                    kHost.eigen_max_align_bytes);
  comparison.number("NDEBUG (CMAKE_BUILD_TYPE=Release sets it)", plugin.ndebug, kHost.ndebug);
  comparison.finish(file);
}

std::string file_name(std::string_view kind, std::string_view name) {
  return std::string(kPrefix) + std::string(kind) + "_" + std::string(name) + std::string(kSuffix);
}

const std::string& libtorch_of(const Registry& registry, const char* kind, const fs::path& file) {
  try {
    return registry.libtorch_of(text_of(kind));
  } catch (const PluginError& error) {
    throw PluginError(file.string() + ": " + error.what());
  }
}

OpenPlugin open_plugin(const fs::path& given, const Registry& registry) {
  const fs::path file = fs::absolute(given).lexically_normal();
  const boost::dll::shared_library library = open(file);
  auto* const info_function = symbol<InfoFunction>(library, "arbox_plugin_info", file);
  auto* const register_function = symbol<RegisterFunction>(library, "arbox_plugin_register", file);
  const ArboxPluginInfo* info = info_function();
  if (info == nullptr) throw PluginError(file.string() + ": arbox_plugin_info gives nothing");
  compare_layout(*info, file);
  compare_build(info->build, libtorch_of(registry, info->kind, file), file);
  const std::string expected = file_name(text_of(info->kind), text_of(info->name));
  if (file.filename() != expected) {
    throw PluginError(file.string() + ": expected the file name " + expected + " of the " +
                      text_of(info->kind) + " '" + text_of(info->name) + "'");
  }
  return {{file, text_of(info->kind), text_of(info->name), text_of(info->version),
           text_of(info->licence)},
          register_function};
}

bool is_plugin_name(const std::string& name) {
  return name.starts_with(kPrefix) && name.ends_with(kSuffix) &&
         name.find('_', kPrefix.size()) != std::string::npos;
}

}  // namespace

PluginDescription inspect_plugin(const fs::path& file, const Registry& registry) {
  return open_plugin(file, registry).description;
}

PluginDescription load_plugin(const fs::path& file, Registry& registry) {
  const OpenPlugin plugin = open_plugin(file, registry);
  const PluginDescription& description = plugin.description;
  const std::string origin = description.file.string();
  if (registry.contains(description.kind, description.name) &&
      registry.find(description.kind, description.name).origin == origin) {
    return description;
  }
  try {
    registry.add_plugin(origin, description.kind, description.name, plugin.register_function);
  } catch (const PluginError&) {
    throw;
  } catch (const std::exception& error) {
    throw PluginError(origin + ": failed to register: " + error.what());
  } catch (...) {
    throw PluginError(origin + ": failed to register: threw what is no std::exception");
  }
  return description;
}

void require_plugin(std::string_view kind, std::string_view name, Registry& registry) {
  if (registry.contains(kind, name)) return;
  const std::string start = std::string(kPrefix) + std::string(kind) + "_";
  std::vector<std::string> known;
  for (const RegistryEntry& entry : registry.entries()) {
    if (entry.kind == kind) known.push_back(entry.name);
  }
  for (const fs::path& file : find_plugins()) {
    const std::string found = file.filename().string();
    if (found == file_name(kind, name)) {
      load_plugin(file, registry);
      return;
    }
    if (found.starts_with(start)) {
      known.push_back(found.substr(start.size(), found.size() - start.size() - kSuffix.size()));
    }
  }
  throw PluginError(unknown_name_text(kind, name, known));
}

std::vector<fs::path> plugin_folders() {
  std::vector<fs::path> folders;
  const char* path = std::getenv("ARBOX_PLUGIN_PATH");
  std::istringstream parts(path == nullptr ? "" : path);
  for (std::string part; std::getline(parts, part, ':');) {
    if (!fs::path(part).is_absolute()) {
      throw ConfigError("ARBOX_PLUGIN_PATH: expected absolute folders, got '" + part + "'");
    }
    folders.emplace_back(part);
  }
  folders.push_back(boost::dll::this_line_location().parent_path() / "arbox" / "plugins");
  return folders;
}

std::vector<fs::path> find_plugins() {
  std::vector<fs::path> files;
  for (const fs::path& folder : plugin_folders()) {
    std::error_code missing;
    std::vector<fs::path> found;
    for (const auto& entry : fs::directory_iterator(folder, missing)) {
      if (is_plugin_name(entry.path().filename().string())) found.push_back(entry.path());
    }
    std::sort(found.begin(), found.end());
    files.insert(files.end(), found.begin(), found.end());
  }
  return files;
}

}  // namespace arbox
