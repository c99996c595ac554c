#include "arbox/heads/distribution_boxes.h"

#include <ATen/TensorOperators.h>

#include <utility>

#include "arbox/base/options.h"
#include "arbox/geometry/confidence_box.h"
#include "arbox/heads/internal/finite_boxes.h"

namespace arbox::heads {
namespace {

/// The quantiles that are asked for and the two of the uncertainty.
std::vector<double> all_quantiles(const DistributionBoxOptions& options) {
  std::vector<double> qs = options.quantiles;
  qs.push_back(options.uncertainty_first);
  qs.push_back(options.uncertainty_second);
  return qs;
}

void distribute(std::vector<geometry::QuantileBox> boxes, const DistributionBoxOptions& options,
                ObjectBoxes& object) {
  object.uncertainty =
      geometry::quantile_uncertainty(boxes[boxes.size() - 2].box, boxes[boxes.size() - 1].box);
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
  const geometry::QuantileOptions quantile_options{
      .points_per_box = options.points_per_box, .seed = streams.seed, .threads = options.threads};
  auto boxes = geometry::quantile_boxes(usable, all_quantiles(options), quantile_options);
  auto confidence = geometry::confidence_boxes(usable, options.confidences, quantile_options);
  for (std::size_t k = 0; k < owners.size(); ++k) {
    ObjectBoxes& object = result.objects[owners[k]];
    distribute(std::move(boxes[k]), options, object);
    object.confidence_boxes = std::move(confidence[k]);
  }
  return result;
}

}  // namespace arbox::heads
