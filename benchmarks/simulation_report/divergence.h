#pragma once

#include <utility>

#include "scan_figures.h"

namespace arbox::benchmarks {

using Select = Histogram (*)(const ScanFigures&);
using Scans = std::vector<const ScanFigures*>;

Scans all_of(const std::vector<ScanFigures>& scans);
/// Two random halves of the scans.
std::pair<Scans, Scans> halves(const std::vector<ScanFigures>& scans, std::uint64_t draw);
/// The histogram of all scans together, as shares.
Histogram shares(const Scans& scans, Select select);

/// Cars that are hardly occluded, by three bands of distance and four of points times squared
/// distance: what a car of a distance returns, in bins that a dozen scans can fill.
Histogram points_by_distance(const ScanFigures& scan);

/// A table: divergence of the real and the simulated scans; that of halves of the real scans; and
/// that of as many simulated scans as there are real ones from the other simulated ones, which is
/// what the small number of scans alone makes.
void print_divergences(const std::vector<ScanFigures>& real,
                       const std::vector<ScanFigures>& simulated);

}  // namespace arbox::benchmarks
