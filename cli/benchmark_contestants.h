#pragma once

#include <memory>
#include <string>
#include <vector>

#include "arbox/cli/outdoor_benchmark.h"
#include "arbox/detectors/detector.h"

namespace arbox::cli {

/// A detector of one head and one box, and what it is asked for.
struct Contestant {
  std::string name, box;
  std::unique_ptr<detectors::Detector> detector;
  detectors::DetectionRequest request;
};

/// "q 0.20": the box of a row of quantile boxes.
std::string quantile_name(double q);

/// The pointwise branch; heads with their own box and their mean, those without a distribution with
/// their only one; the classical baseline. Quantile boxes come with the heads' own, `alone` from
/// detectors that are asked for nothing else. Throws UsageError if there are none; what loading a
/// model throws.
std::vector<Contestant> contestants(const OutdoorBenchmarkOptions& options, bool alone);

}  // namespace arbox::cli
