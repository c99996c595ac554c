#include "arbox/heads/box_distribution.h"

#include <ATen/TensorOperators.h>

#include <string>

#include "arbox/base/error.h"
#include "arbox/heads/box_codec.h"

namespace arbox::heads {

BoxCodec::~BoxCodec() = default;
BoxDistribution::~BoxDistribution() = default;

at::Tensor BoxDistribution::log_size_density(const at::Tensor&) const {
  throw NotAvailable("log_size_density: this head has no density of sizes alone");
}

at::Tensor entropy(const BoxDistribution& distribution, int draws, const Streams& streams) {
  if (distribution.measure() == Measure::kNone) {
    throw NotAvailable("entropy: this head has no likelihood");
  }
  return -distribution.sample(draws, streams).log_density.mean(1);
}

void require_draws(int count, const Streams& streams, double temperature, std::int64_t objects) {
  if (count < 1 || !(temperature > 0.0)) {
    throw InvalidArgument("sample: expected a count of at least 1 and a temperature above 0, got " +
                          std::to_string(count) + " and " + std::to_string(temperature));
  }
  const at::Tensor& ids = streams.object_ids;
  if (!ids.defined() || ids.dim() != 1 || ids.size(0) != objects ||
      ids.scalar_type() != at::kLong) {
    throw InvalidArgument("sample: expected one int64 object id for each of the " +
                          std::to_string(objects) + " objects");
  }
}

void require_mode_options(const ModeOptions& options) {
  if (options.beam_width < 1) {
    throw InvalidArgument("mode: expected a beam width of at least 1, got " +
                          std::to_string(options.beam_width));
  }
  if (!(options.smoothing >= 0.0 && options.smoothing <= 1000.0)) {
    throw InvalidArgument("mode: expected a smoothing of 0 to 1000 bins, got " +
                          std::to_string(options.smoothing));
  }
}

void require_sizes(const at::Tensor& sizes, std::int64_t objects) {
  const bool fits =
      sizes.defined() && sizes.dim() == 2 && sizes.size(0) == objects && sizes.size(1) == 3;
  if (fits && (sizes > 0).logical_and(sizes < 1e30).all().item<bool>()) return;
  throw InvalidArgument("given_sizes: expected sizes (" + std::to_string(objects) +
                        ", 3), finite and above zero");
}

}  // namespace arbox::heads
