#include "arbox/cli/benchmark_contestants.h"

#include <algorithm>

#include "arbox/cli/command_line.h"
#include "arbox/cli/detector_flags.h"
#include "arbox/cli/torch_module.h"
#include "arbox/io/model_search.h"

namespace arbox::cli {
namespace {

detectors::DetectionRequest plain_request(const OutdoorBenchmarkOptions& options) {
  return {.score = options.score, .uncertainty = false};
}

/// The quantiles asked for, and those that the paper ranks by uncertainty.
std::vector<double> sought_quantiles(const OutdoorBenchmarkOptions& options) {
  std::vector<double> quantiles = options.quantiles;
  for (const double q : {0.2, 0.5, 0.8}) {
    if (std::find(quantiles.begin(), quantiles.end(), q) == quantiles.end()) quantiles.push_back(q);
  }
  return quantiles;
}

Contestant model_contestant(const OutdoorBenchmarkOptions& options, const std::string& name,
                            const std::string& head, const std::string& box,
                            const detectors::DetectionRequest& request) {
  DetectorFlags flags;
  flags.model = options.model;
  flags.head = head;
  flags.mode = box;
  return {.name = name, .box = box, .detector = make_detector(flags), .request = request};
}

Contestant quantile_contestant(const OutdoorBenchmarkOptions& options, const std::string& head,
                               double q) {
  DetectorFlags flags;
  flags.model = options.model;
  flags.head = head;
  flags.mode = "quantile";
  flags.overrides = {"post.quantile=" + std::to_string(q)};
  return {.name = head,
          .box = quantile_name(q),
          .detector = make_detector(flags),
          .request = plain_request(options)};
}

Contestant cluster_fit_contestant(const detectors::DetectionRequest& request) {
  DetectorFlags flags;
  flags.detector = "cluster_fit";
  return {
      .name = "cluster_fit", .box = "box", .detector = make_detector(flags), .request = request};
}

/// The heads to compare, in the order asked for. Names that the model lacks are kept: loading it
/// with them says what it has.
std::vector<ModelHead> heads_of(const OutdoorBenchmarkOptions& options) {
  if (options.model.empty()) return {};
  auto all = torch_module().model_heads(io::find_model(options.model).string());
  if (options.heads.empty()) return all;
  std::vector<ModelHead> heads;
  for (const std::string& name : options.heads) {
    const auto found = std::find_if(all.begin(), all.end(),
                                    [&](const ModelHead& one) { return one.name == name; });
    heads.push_back(found == all.end() ? ModelHead{name} : *found);
  }
  return heads;
}

}  // namespace

std::string quantile_name(double q) { return "q " + std::to_string(q).substr(0, 4); }

std::vector<Contestant> contestants(const OutdoorBenchmarkOptions& options, bool alone) {
  const detectors::DetectionRequest plain = plain_request(options);
  detectors::DetectionRequest sampled = plain;
  if (!alone) {
    sampled.quantiles = sought_quantiles(options);
    sampled.samples = sampled.uncertainty = true;
  }
  std::vector<Contestant> result;
  const auto heads = heads_of(options);
  if (!heads.empty()) {
    result.push_back(model_contestant(options, "pointwise", heads[0].name, "pointwise", plain));
  }
  for (const auto& [head, has_distribution] : heads) {
    if (head == "pointwise") continue;
    if (!has_distribution) {
      result.push_back(model_contestant(options, head, head, "beam", plain));
      result.back().box = "box";
      continue;
    }
    detectors::DetectionRequest request = sampled;
    if (!alone && head == heads[0].name) request.confidences = options.confidences;
    result.push_back(model_contestant(options, head, head, "beam", request));
    result.push_back(model_contestant(options, head, head, "mean", plain));
    if (!alone) continue;
    for (const double q : options.quantiles) {
      result.push_back(quantile_contestant(options, head, q));
    }
  }
  if (options.cluster_fit) result.push_back(cluster_fit_contestant(sampled));
  if (result.empty()) throw UsageError("benchmark: expected a model or cluster_fit, got neither");
  return result;
}

}  // namespace arbox::cli
