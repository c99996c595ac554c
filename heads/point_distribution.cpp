#include "arbox/heads/point_distribution.h"

#include <utility>

#include "arbox/base/error.h"
#include "arbox/heads/box_tensor.h"
#include "arbox/heads/internal/component_math.h"

namespace arbox::heads {

using at::Tensor;

PointDistribution::PointDistribution(Tensor boxes) : boxes_(std::move(boxes)) {
  require_boxes(boxes_, "PointDistribution");
}

PointDistribution::PointDistribution(const Tensor& components,
                                     std::shared_ptr<const BoxCodec> codec,
                                     const References& references)
    : codec_(std::move(codec)), references_(references.detached()) {
  components_ = components.detach().to(at::kFloat);
  boxes_ = codec_->decode(components_.unsqueeze(1), references_).select(1, 0);
}

Draws PointDistribution::repeated(std::int64_t count) const {
  Draws draws;
  draws.boxes = boxes_.unsqueeze(1).expand({size(), count, kBoxColumns}).contiguous();
  if (components_.defined()) {
    draws.components =
        components_.unsqueeze(1).expand({size(), count, components_.size(1)}).contiguous();
  }
  return draws;
}

Draws PointDistribution::mode(const ModeOptions& options) const {
  require_mode_options(options);
  return repeated(1);
}

Draws PointDistribution::sample(int count, const Streams& streams, double temperature) const {
  require_draws(count, streams, temperature, size());
  return repeated(count);
}

Tensor PointDistribution::log_density(const Tensor&) const {
  throw NotAvailable("log_density: this head predicts one box and has no likelihood");
}

std::unique_ptr<BoxDistribution> PointDistribution::select(const Tensor& index) const {
  if (!codec_) return std::make_unique<PointDistribution>(boxes_.index_select(0, index));
  return std::make_unique<PointDistribution>(components_.index_select(0, index), codec_,
                                             references_.select(index));
}

std::unique_ptr<BoxDistribution> PointDistribution::given_sizes(const Tensor& sizes) const {
  if (!codec_ || codec_->size_components().size() != 3) {
    throw NotAvailable("given_sizes: the size is no part of what this head predicts");
  }
  require_sizes(sizes, size());
  const Tensor known = internal::size_values(sizes, *codec_, references_);
  return std::make_unique<PointDistribution>(
      internal::with_sizes(components_.unsqueeze(1), *codec_, known).select(1, 0), codec_,
      references_);
}

}  // namespace arbox::heads
