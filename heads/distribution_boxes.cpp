#include "arbox/heads/distribution_boxes.h"

#include <ATen/TensorOperators.h>

#include <utility>

#include "arbox/base/options.h"
#include "arbox/heads/internal/finite_boxes.h"

namespace arbox::heads {
namespace {

/// Every q that is asked for: the quantiles, those of the confidences, the two of the uncertainty.
std::vector<double> all_quantiles(const DistributionBoxOptions& options) {
  std::vector<double> qs = options.quantiles;
  for (const double p : options.confidences) qs.push_back(1.0 - p);
  qs.push_back(options.uncertainty_first);
  qs.push_back(options.uncertainty_second);
  return qs;
}

void distribute(std::vector<geometry::QuantileBox> boxes, const DistributionBoxOptions& options,
                ObjectBoxes& object) {
  object.uncertainty =
      geometry::quantile_uncertainty(boxes[boxes.size() - 2].box, boxes[boxes.size() - 1].box);
  for (std::size_t i = 0; i < options.confidences.size(); ++i) {
    object.confidence_boxes.push_back(
        {options.confidences[i], boxes[options.quantiles.size() + i].box});
  }
  boxes.resize(options.quantiles.size());
  object.quantile_boxes = std::move(boxes);
}

}  // namespace

DistributionBoxes distribution_boxes(const BoxDistribution& distribution, const Streams& streams,
                                     const DistributionBoxOptions& options) {
  validate_options(options, "boxes of a distribution");
  const bool single_box = distribution.measure() == Measure::kNone;
  const Draws draws =
      distribution.sample(single_box ? 1 : options.samples, streams, options.temperature);
  DistributionBoxes result;
  result.single_box = single_box;
  result.objects.resize(distribution.size());
  std::vector<geometry::BoxSamples> usable;
  std::vector<std::size_t> owners;
  for (std::int64_t i = 0; i < distribution.size(); ++i) {
    ObjectBoxes& object = result.objects[i];
    object.samples = internal::finite_boxes(draws.boxes[i]).boxes;
    object.dropped = draws.boxes.size(1) - std::ssize(object.samples);
    result.dropped += object.dropped;
    if (object.samples.empty()) continue;
    owners.push_back(i);
    usable.push_back(
        {.boxes = object.samples,
         .object = static_cast<std::uint64_t>(streams.object_ids[i].item<std::int64_t>())});
  }
  auto boxes = geometry::quantile_boxes(
      usable, all_quantiles(options),
      {.points_per_box = options.points_per_box, .seed = streams.seed, .threads = options.threads});
  for (std::size_t k = 0; k < owners.size(); ++k) {
    distribute(std::move(boxes[k]), options, result.objects[owners[k]]);
  }
  return result;
}

}  // namespace arbox::heads
