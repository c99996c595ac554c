#pragma once

#include <memory>

#include "arbox/heads/box_codec.h"
#include "arbox/heads/independent_distribution.h"

namespace arbox::heads {

/// values (N, M, D), mean and deviation (N, D) -> (N, M, D): log density of independent normals,
/// wrapped where a component is circular (4 turns to both sides: exact to 1e-3 up to a deviation of
/// 1.4 periods). Differentiable in all.
at::Tensor gaussian_log_density(const at::Tensor& values, const at::Tensor& mean,
                                const at::Tensor& deviation, std::span<const Component> components);

/// Independent normals over the components of a codec. mode() is the mean, one vector whatever the
/// beam width. Samples at a temperature T have deviations times sqrt(T). Normals reach below a size
/// of zero; boxes then have the codec's least size, while components and densities stay as drawn.
class GaussianDistribution : public IndependentDistribution {
 public:
  /// mean, deviation (N, D), deviations above zero.
  GaussianDistribution(const at::Tensor& mean, const at::Tensor& deviation,
                       std::shared_ptr<const BoxCodec> codec, const References& references);

  Draws mode(const ModeOptions& options) const override;
  Draws sample(int count, const Streams& streams, double temperature) const override;
  at::Tensor mean() const override;
  at::Tensor log_density(const at::Tensor& boxes) const override;

 private:
  std::unique_ptr<IndependentDistribution> clone() const override;
  void keep_rows(const at::Tensor& index) override;
  at::Tensor density_of(const at::Tensor& values, const std::vector<int>& of) const override;
  Draws draws_of(const at::Tensor& values) const;
  /// (N, M, D) -> (N, M), without the size components where they are known.
  at::Tensor vector_density(const at::Tensor& values) const;

  at::Tensor mean_, deviation_;
};

}  // namespace arbox::heads
