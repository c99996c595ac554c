#define BOOST_DLL_USE_STD_FS
#include "arbox/cli/viewer_module.h"

#include <boost/dll/shared_library.hpp>
#include <cstdlib>
#include <filesystem>

#include "arbox/base/plugin_loader.h"
#include "arbox/cli/command_line.h"

namespace arbox::cli {
namespace {

constexpr const char* kViewerFile = "libarbox_program_viewer.so";

ViewInteractively& open_viewer() {
  // Beside the folder of the installation's plugins, which is the last to be searched.
  const std::filesystem::path file = plugin_folders().back().parent_path() / kViewerFile;
  if (!std::filesystem::is_regular_file(file)) {
    throw NotAvailable("this installation of Arbox has no viewer: " + file.string() +
                       " is missing, install the package arbox-viewer (or use --html, --output)");
  }
  static auto* const library = new boost::dll::shared_library(
      file, boost::dll::load_mode::rtld_now | boost::dll::load_mode::rtld_local);
  return library->get<ViewInteractively>("arbox_view_interactively");
}

}  // namespace

void view_interactively(const drawing::Scene& scene, const drawing::SceneOptions& options) {
  // VTK ends the process without a display, so it is asked for before.
  const char* display = std::getenv("DISPLAY");
  if (display == nullptr || *display == '\0') {
    throw UsageError(
        "--interactive needs a display, and DISPLAY is not set: use --html or --output");
  }
  if (!open_viewer()(scene, options)) {
    throw UsageError(std::string("--interactive: the display '") + display +
                     "' cannot be opened: use --html or --output");
  }
}

}  // namespace arbox::cli
