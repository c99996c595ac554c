#include "arbox/cli/viewer_module.h"

#include <cstdlib>

#include "arbox/base/lazy_library.h"
#include "arbox/cli/command_line.h"

namespace arbox::cli {
namespace {

constexpr LazyLibrary kViewerLibrary = {
    .file = "libarbox_program_viewer.so",
    .content = "viewer",
    .mend = "install the package arbox-viewer (or use --html, --output)"};

}  // namespace

void view_interactively(const drawing::Scene& scene, const drawing::SceneOptions& options) {
  // VTK ends the process without a display, so it is asked for before.
  const char* display = std::getenv("DISPLAY");
  if (display == nullptr || *display == '\0') {
    throw UsageError(
        "--interactive needs a display, and DISPLAY is not set: use --html or --output");
  }
  auto* const view = find_function<ViewInteractively>(kViewerLibrary, "arbox_view_interactively");
  if (!view(scene, options)) {
    throw UsageError(std::string("--interactive: the display '") + display +
                     "' cannot be opened: use --html or --output");
  }
}

}  // namespace arbox::cli
