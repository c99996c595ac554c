#pragma once

#include <boost/dll/shared_library.hpp>
#include <filesystem>

namespace arbox::internal {

/// Opens a shared library with RTLD_NOW | RTLD_LOCAL and never closes it: objects and code of it
/// may be in use until the very end of the process. Throws what Boost.DLL throws.
boost::dll::shared_library open_forever(const std::filesystem::path& file);

}  // namespace arbox::internal
