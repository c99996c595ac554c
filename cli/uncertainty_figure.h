#pragma once

#include <span>
#include <string>

#include "arbox/drawing/image.h"
#include "arbox/evaluation/uncertainty_protocol.h"

namespace arbox::cli {

/// Containment against promise of each class, and the IoU of each found object against its
/// uncertainty, where there is any.
drawing::Image draw_uncertainty(const evaluation::UncertaintyReport& report);

/// One of several detectors whose promises are compared.
struct NamedUncertainty {
  std::string name;
  evaluation::UncertaintyReport report;
};

/// Containment against promise over all classes, a line for each detector.
drawing::Image draw_containment(std::span<const NamedUncertainty> detectors,
                                const std::string& title);

}  // namespace arbox::cli
