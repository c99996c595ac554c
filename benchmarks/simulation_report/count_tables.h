#pragma once

#include "scan_figures.h"

namespace arbox::benchmarks {

/// Tables: points a scan, points an object by class and distance, beams without return by ring.
void print_counts(const std::vector<ScanFigures>& real, const std::vector<ScanFigures>& simulated);

}  // namespace arbox::benchmarks
