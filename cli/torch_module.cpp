#include "arbox/cli/torch_module.h"

#include "arbox/detectors/networks_library.h"

namespace arbox::cli {

using detectors::kNetworksLibrary;

const TorchModule& torch_module() {
  static const TorchModule& module =
      *find_function<const TorchModule*()>(kNetworksLibrary, "arbox_torch_module")();
  return module;
}

bool has_torch_module() { return is_installed(kNetworksLibrary); }

}  // namespace arbox::cli
