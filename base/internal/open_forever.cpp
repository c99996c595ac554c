#include "arbox/base/internal/open_forever.h"

#include <mutex>
#include <vector>

namespace arbox::internal {

boost::dll::shared_library open_forever(const std::filesystem::path& file) {
  static std::mutex mutex;
  static auto* const kept = new std::vector<boost::dll::shared_library>;
  boost::dll::shared_library library(
      file, boost::dll::load_mode::rtld_now | boost::dll::load_mode::rtld_local);
  const std::scoped_lock lock(mutex);
  kept->push_back(library);
  return library;
}

}  // namespace arbox::internal
