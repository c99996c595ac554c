#pragma once

#include <memory>
#include <string_view>

#include "arbox/base/registry.h"
#include "arbox/detectors/detector.h"

namespace arbox::detectors {

/// Detectors as a kind that can be chosen by name and brought by plugins (base/registry.h). A
/// detector's room offers `void register_NAME(Registrar&)`, which adds it with its options struct.
struct DetectorKind {
  static constexpr std::string_view kName = "detector";
  using Factory = std::unique_ptr<Detector>(const OptionsInstance& options);
};

}  // namespace arbox::detectors
