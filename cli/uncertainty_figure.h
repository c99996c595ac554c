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

/// The Gaussian head's boxes with the deviation of sizes for their uncertainty
/// (evaluation::use_gaussian_uncertainty): another doubt about the same boxes.
inline constexpr char kGaussianDeviation[] = "gaussian, G";

/// Fact against promise over all classes, a line for each detector: how often quantile boxes
/// contain their objects, beside 1 - q and beside the share of the samples that they hold, how
/// often boxes of the samples do, and how often boxes overlap theirs. Leaves out
/// kGaussianDeviation, which has the promises of the Gaussian head.
drawing::Image draw_promises(std::span<const NamedUncertainty> detectors, const std::string& title);

}  // namespace arbox::cli
