#include "arbox/base/plugin_abi.h"

namespace arbox::testing {

std::size_t align_without_eigen() { return ARBOX_EIGEN_MAX_ALIGN_BYTES; }

}  // namespace arbox::testing
