#define BOOST_DLL_USE_STD_FS
#include "arbox/cli/torch_module.h"

#include <boost/dll/shared_library.hpp>
#include <filesystem>

#include "arbox/base/error.h"
#include "arbox/base/plugin_loader.h"

namespace arbox::cli {
namespace {

constexpr const char* kFile = "libarbox_program_torch.so";

/// Beside the folder of the installation's plugins, which is the last to be searched.
std::filesystem::path file() { return plugin_folders().back().parent_path() / kFile; }

const TorchModule& open() {
  if (!has_torch_module()) {
    throw NotAvailable("this installation of Arbox has no networks: " + file().string() +
                       " is missing, install the component 'program_torch'");
  }
  // Code of it may be in use until the process ends: never closed.
  static auto* const library = new boost::dll::shared_library(
      file(), boost::dll::load_mode::rtld_now | boost::dll::load_mode::rtld_local);
  return *library->get<const TorchModule*()>("arbox_torch_module")();
}

}  // namespace

const TorchModule& torch_module() {
  static const TorchModule& module = open();
  return module;
}

bool has_torch_module() { return std::filesystem::is_regular_file(file()); }

}  // namespace arbox::cli
