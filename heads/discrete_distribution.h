#pragma once

#include <memory>
#include <vector>

#include "arbox/heads/box_codec.h"
#include "arbox/heads/box_distribution.h"
#include "arbox/heads/quantizer.h"

namespace arbox::heads {

/// Independent bins of each component of a codec. mode() is exact: the most likely vectors of the
/// product, best first. mean() is exact. log_density() sums over the distinct equivalent vectors
/// and is -infinity where all of them lie outside of the codec's ranges. given_sizes() fixes the
/// sizes and leaves the rest as it is, since the components are independent.
class DiscreteDistribution : public BoxDistribution {
 public:
  /// log_probability[i] (N, usable bins) of component i. `sizes` (N, 3): known values of the size
  /// components, or undefined.
  DiscreteDistribution(std::vector<at::Tensor> log_probability, CircularEnds ends,
                       std::shared_ptr<const BoxCodec> codec, References references,
                       at::Tensor sizes = {});

  std::int64_t size() const override { return log_probability_.front().size(0); }
  Measure measure() const override { return Measure::kDensity; }
  Draws mode(int beam_width) const override;
  Draws sample(int count, const Streams& streams, double temperature) const override;
  at::Tensor mean() const override;
  at::Tensor log_density(const at::Tensor& boxes) const override;
  std::unique_ptr<BoxDistribution> select(const at::Tensor& index) const override;
  std::unique_ptr<BoxDistribution> given_sizes(const at::Tensor& sizes) const override;

 private:
  Draws draws_of(const at::Tensor& bins) const;
  /// bins (N, M, D) -> (N, M) densities, without the size components where they are known.
  at::Tensor vector_density(const at::Tensor& bins) const;
  bool is_known(int component) const;

  std::vector<at::Tensor> log_probability_;
  CircularEnds ends_;
  std::shared_ptr<const BoxCodec> codec_;
  References references_;
  at::Tensor sizes_;
};

}  // namespace arbox::heads
