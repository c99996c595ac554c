#include "arbox/cli/program_registry.h"

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

}  // namespace arbox::cli
