#include "arbox/base/lazy_library.h"

#include <exception>
#include <filesystem>
#include <string>

#include "arbox/base/error.h"
#include "arbox/base/internal/open_forever.h"
#include "arbox/base/plugin_loader.h"

namespace arbox {
namespace {

// The installation's folder is the last to be searched for plugins.
std::filesystem::path path_of(const LazyLibrary& library) {
  return plugin_folders().back().parent_path() / library.file;
}

}  // namespace

bool is_installed(const LazyLibrary& library) {
  return std::filesystem::is_regular_file(path_of(library));
}

void* find_symbol(const LazyLibrary& library, const char* name) {
  const std::filesystem::path file = path_of(library);
  if (!is_installed(library)) {
    throw NotAvailable("this installation of Arbox has no " + std::string(library.content) + ": " +
                       file.string() + " is missing, " + std::string(library.mend));
  }
  try {
    return reinterpret_cast<void*>(&internal::open_forever(file).get<void()>(name));
  } catch (const std::exception& error) {
    throw NotAvailable(file.string() + ": cannot be loaded: " + error.what());
  }
}

}  // namespace arbox
