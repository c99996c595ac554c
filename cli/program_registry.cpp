#include "arbox/cli/program_registry.h"

#include "arbox/detectors/detector_kind.h"

namespace arbox::cli {
namespace {

Registry make_registry() {
  Registry registry;
  registry.declare<detectors::DetectorKind>();
  return registry;
}

}  // namespace

Registry& program_registry() {
  static Registry registry = make_registry();
  return registry;
}

}  // namespace arbox::cli
