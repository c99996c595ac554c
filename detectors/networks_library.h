#pragma once

#include "arbox/base/lazy_library.h"

namespace arbox::detectors {

/// What of Arbox needs LibTorch, for programs that do not link it (cli/torch_module_library.cpp).
inline constexpr LazyLibrary kNetworksLibrary = {.file = "libarbox_program_torch.so",
                                                 .content = "networks",
                                                 .mend = "install the component 'program_torch'"};

}  // namespace arbox::detectors
