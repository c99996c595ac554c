#include "arbox/cli/program_registry.h"

#include "arbox/cli/torch_module.h"
#include "arbox/detectors/open_detector.h"

namespace arbox::cli {
Registry& program_registry() {
  static Registry registry = detectors::make_detector_registry();
  return registry;
}

Registry& full_program_registry() {
  Registry& registry = program_registry();
  static const bool added = [&] {
    if (!has_torch_module()) return false;
    torch_module().register_built_ins(registry);
    return true;
  }();
  static_cast<void>(added);
  return registry;
}

}  // namespace arbox::cli
