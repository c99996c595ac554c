#include "arbox/detectors/pv_rcnn/internal/head_answer.h"

#include <ATen/TensorOperators.h>
#include <ATen/ops/empty.h>
#include <ATen/ops/zeros.h>

#include <algorithm>
#include <cmath>

#include "arbox/detectors/pv_rcnn/box_coding.h"
#include "arbox/detectors/pv_rcnn/internal/box_rows.h"
#include "arbox/heads/conditioning.h"

namespace arbox::detectors::pv_rcnn::internal {
namespace {

using at::Tensor;

Tensor quantile_rows(const heads::DistributionBoxes& summary, const Tensor& fallback) {
  Tensor rows = fallback.clone();
  for (std::size_t i = 0; i < summary.objects.size(); ++i) {
    if (summary.objects[i].quantile_boxes.empty()) continue;
    const geometry::Box& box = summary.objects[i].quantile_boxes.back().box;
    const double numbers[] = {box.center.x(), box.center.y(), box.center.z(),    box.size.x(),
                              box.size.y(),   box.size.z(),   geometry::yaw(box)};
    for (std::int64_t k = 0; k < kBoxNumbers; ++k) rows[i][k] = numbers[k];
  }
  return rows;
}

bool needs_draws(const DetectionRequest& request, const PostOptions& options) {
  return request.uncertainty || request.samples || options.box == "quantile" ||
         options.scoring == "overlap" || !request.quantiles.empty() || !request.confidences.empty();
}

/// Boxes and what draws tell.
HeadAnswer boxes_of(const heads::BoxDistribution& distribution, const heads::Streams& streams,
                    const Tensor& pointwise, const DetectionRequest& request,
                    const PostOptions& options) {
  HeadAnswer answer;
  heads::DistributionBoxOptions wanted;
  wanted.samples = options.samples;
  wanted.quantiles = request.quantiles;
  wanted.threads = request.threads;
  // The box itself, if it is a quantile box, comes last.
  if (options.box == "quantile") wanted.quantiles.push_back(options.quantile);
  answer.summary.objects.resize(distribution.size());
  if (needs_draws(request, options)) {
    answer.summary = heads::distribution_boxes(distribution, streams, wanted);
  }
  if (options.box == "pointwise") {
    answer.boxes = pointwise;
  } else if (options.box == "mean") {
    answer.boxes = from_box_rows(distribution.mean());
  } else if (options.box == "quantile") {
    answer.boxes = quantile_rows(answer.summary, pointwise);
  } else {
    answer.boxes = from_box_rows(
        distribution.mode({.beam_width = options.beam_width, .smoothing = options.mode_smoothing})
            .boxes.select(1, 0));
  }
  return answer;
}

/// Which known size each of a distribution's objects has; null where none is possible.
std::vector<const geometry::KnownSize*> chosen_sizes(const heads::BoxDistribution& distribution,
                                                     const std::vector<geometry::KnownSize>& known,
                                                     const PostOptions& options) {
  std::vector<const geometry::KnownSize*> chosen;
  for (const heads::ConditionedBox& one :
       heads::given_known_sizes(distribution, known,
                                {.beam_width = options.beam_width,
                                .smoothing = options.mode_smoothing,
                                .score = options.known_sizes,
                                .orders = "given"})) {
    chosen.push_back(std::isfinite(one.log_density) ? &known[one.known_size] : nullptr);
  }
  return chosen;
}

Tensor size_rows(const std::vector<const geometry::KnownSize*>& sizes) {
  Tensor rows = at::zeros({std::ssize(sizes), 3}, at::kDouble);
  double* number = rows.data_ptr<double>();
  for (const geometry::KnownSize* known : sizes) {
    for (const double extent : known->size) *number++ = extent;
  }
  return rows;
}

/// Puts what objects of known size look like in the place of what is known without.
void condition(const heads::BoxDistribution& distribution, const heads::Streams& streams,
               const Tensor& pointwise, const std::vector<std::int64_t>& rows,
               const std::vector<geometry::KnownSize>& known, const DetectionRequest& request,
               const PostOptions& options, HeadAnswer& answer) {
  const auto chosen = chosen_sizes(*distribution.select(index_tensor(rows)), known, options);
  std::vector<std::int64_t> sized;
  std::vector<const geometry::KnownSize*> sizes;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (chosen[i] == nullptr) continue;
    sized.push_back(rows[i]);
    sizes.push_back(chosen[i]);
  }
  if (sized.empty()) return;
  const Tensor index = index_tensor(sized);
  PostOptions of_known_size = options;
  // The pointwise branch does not know of sizes.
  if (options.box == "pointwise") of_known_size.box = "mode";
  HeadAnswer given = boxes_of(*distribution.select(index)->given_sizes(size_rows(sizes)),
                              {streams.seed, streams.object_ids.index_select(0, index)},
                              pointwise.index_select(0, index), request, of_known_size);
  answer.boxes = answer.boxes.index_copy(0, index, given.boxes.to(answer.boxes.scalar_type()));
  for (std::size_t i = 0; i < sized.size(); ++i) {
    answer.known_sizes[sized[i]] = sizes[i];
    answer.summary.objects[sized[i]] = std::move(given.summary.objects[i]);
  }
}

std::vector<std::int64_t> rows_of_class(const std::vector<int>& labels, std::int64_t label) {
  std::vector<std::int64_t> rows;
  for (std::size_t i = 0; i < labels.size(); ++i) {
    if (labels[i] == label) rows.push_back(static_cast<std::int64_t>(i));
  }
  return rows;
}

}  // namespace

at::Tensor index_tensor(const std::vector<std::int64_t>& index) {
  Tensor result = at::empty({std::ssize(index)}, at::kLong);
  std::copy(index.begin(), index.end(), result.data_ptr<std::int64_t>());
  return result;
}

HeadAnswer ask(heads::BoxHead& head, const heads::HeadInput& input, const std::vector<int>& labels,
               const Tensor& pointwise, const DetectionRequest& request, const Options& options) {
  const auto distribution = head.forward(input);
  const heads::Streams streams = input.streams();
  HeadAnswer answer = boxes_of(*distribution, streams, pointwise, request, options.post);
  if (!request.known_sizes.empty()) {
    answer.known_sizes.resize(labels.size());
    for (const auto& object : answer.summary.objects) {
      if (!request.confidences.empty()) answer.free_samples.push_back(object.samples);
    }
  }
  for (const auto& [name, known] : request.known_sizes) {
    const auto label = std::find(options.classes.begin(), options.classes.end(), name);
    const auto rows = rows_of_class(labels, label - options.classes.begin());
    if (rows.empty()) continue;
    condition(*distribution, streams, pointwise, rows, known, request, options.post, answer);
  }
  if (distribution->measure() == heads::Measure::kDensity) {
    answer.log_density = distribution->log_density(to_box_rows(answer.boxes)).to(at::kDouble);
  }
  return answer;
}

}  // namespace arbox::detectors::pv_rcnn::internal
