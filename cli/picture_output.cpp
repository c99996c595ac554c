#include "arbox/cli/picture_output.h"

#include "arbox/cli/command_line.h"
#include "arbox/drawing/image.h"

namespace arbox::cli {

void require_picture(const std::string& flag, const std::filesystem::path& path) {
  try {
    drawing::require_image_extension(path);
  } catch (const InvalidArgument& error) {
    throw UsageError(flag + ": " + error.what());
  }
}

}  // namespace arbox::cli
