#pragma once

#include "scan_figures.h"

namespace arbox::benchmarks {

/// A classifier that shall tell real from simulated cars of matched distance by features of their
/// points: its area under the ROC curve, and the features' quantiles.
void print_classifier(const std::vector<ScanFigures>& real,
                      const std::vector<ScanFigures>& simulated);

}  // namespace arbox::benchmarks
