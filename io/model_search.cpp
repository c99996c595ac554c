#include "arbox/io/model_search.h"

#include <dlfcn.h>

#include <algorithm>
#include <cstdlib>
#include <sstream>
#include <system_error>

#include "arbox/base/error.h"
#include "arbox/base/names.h"

namespace arbox::io {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kExtension = ".arbox";

/// share/arbox/models beside the folder of this library, or beside that folder's parent
/// (lib/x86_64-linux-gnu).
std::vector<fs::path> installed_folders() {
  Dl_info place;
  if (dladdr(reinterpret_cast<const void*>(&find_model), &place) == 0) return {};
  std::error_code error;
  const fs::path library = fs::canonical(place.dli_fname, error);
  if (error) return {};
  const fs::path share = fs::path("share") / "arbox" / "models";
  const fs::path prefix = library.parent_path().parent_path();
  return {prefix / share, prefix.parent_path() / share};
}

std::vector<std::string> known_models(const std::vector<fs::path>& folders) {
  std::vector<std::string> names;
  for (const fs::path& folder : folders) {
    std::error_code missing;
    for (const auto& entry : fs::directory_iterator(folder, missing)) {
      if (entry.path().extension() == kExtension) names.push_back(entry.path().stem().string());
    }
  }
  std::sort(names.begin(), names.end());
  names.erase(std::unique(names.begin(), names.end()), names.end());
  return names;
}

}  // namespace

std::vector<fs::path> model_folders() {
  std::vector<fs::path> folders;
  const char* path = std::getenv("ARBOX_MODEL_PATH");
  std::istringstream parts(path == nullptr ? "" : path);
  for (std::string part; std::getline(parts, part, ':');) {
    if (!fs::path(part).is_absolute()) {
      throw ConfigError("ARBOX_MODEL_PATH: expected absolute folders, got '" + part + "'");
    }
    folders.emplace_back(part);
  }
  for (const fs::path& folder : installed_folders()) folders.push_back(folder);
  return folders;
}

fs::path find_model(const std::string& name) {
  std::error_code error;
  if (name.find('/') != std::string::npos || name.ends_with(kExtension)) {
    if (fs::is_directory(name, error)) throw IoError(name + ": expected a model, got a directory");
    if (!fs::exists(name, error)) throw IoError(name + ": no such file");
    return name;
  }
  const std::vector<fs::path> folders = model_folders();
  for (const fs::path& folder : folders) {
    const fs::path file = folder / (name + std::string(kExtension));
    if (fs::is_regular_file(file, error)) return file;
  }
  const std::vector<std::string> known = known_models(folders);
  if (known.empty()) {
    throw IoError("model '" + name +
                  "': no models are installed; give the path of a .arbox file, " +
                  "or name a folder of models in ARBOX_MODEL_PATH");
  }
  throw IoError(unknown_name_text("model", name, known));
}

}  // namespace arbox::io
