#include "arbox/cli/program_registry.h"

#include "arbox/cli/torch_module.h"
#include "arbox/detectors/cluster_fit/cluster_fit.h"
#include "arbox/detectors/detector_kind.h"

namespace arbox::cli {
namespace {

Registry make_registry() {
  Registry registry;
  registry.declare<detectors::DetectorKind>();
  registry.add_built_in(detectors::register_cluster_fit);
  return registry;
}

}  // namespace

Registry& program_registry() {
  static Registry registry = make_registry();
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
