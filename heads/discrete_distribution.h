#pragma once

#include <memory>
#include <vector>

#include "arbox/heads/box_codec.h"
#include "arbox/heads/independent_distribution.h"
#include "arbox/heads/quantizer.h"

namespace arbox::heads {

/// Independent bins of each component of a codec. mode() is exact: the most likely vectors of the
/// product, best first. mean() is exact. log_density() sums over the distinct equivalent vectors
/// and is -infinity where all of them lie outside of the codec's ranges.
class DiscreteDistribution : public IndependentDistribution {
 public:
  /// log_probability[i] (N, usable bins) of component i.
  DiscreteDistribution(const std::vector<at::Tensor>& log_probability, CircularEnds ends,
                       std::shared_ptr<const BoxCodec> codec, const References& references);

  Draws mode(const ModeOptions& options) const override;
  Draws sample(int count, const Streams& streams, double temperature) const override;
  at::Tensor mean() const override;
  at::Tensor log_density(const at::Tensor& boxes) const override;

 private:
  DiscreteDistribution smoothed(double standard_deviation) const;
  std::unique_ptr<IndependentDistribution> clone() const override;
  void keep_rows(const at::Tensor& index) override;
  at::Tensor density_of(const at::Tensor& values, const std::vector<int>& of) const override;
  Draws draws_of(const at::Tensor& bins) const;
  /// bins (N, M, D) -> (N, M): log density of one component.
  at::Tensor component_density(const at::Tensor& bins, int component) const;
  /// bins (N, M, D) -> (N, M) densities, without the size components where they are known.
  at::Tensor vector_density(const at::Tensor& bins) const;

  std::vector<at::Tensor> log_probability_;
  CircularEnds ends_;
};

}  // namespace arbox::heads
