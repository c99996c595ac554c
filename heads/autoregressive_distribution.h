#pragma once

#include <cstdint>
#include <memory>

#include "arbox/heads/autoregressive_model.h"
#include "arbox/heads/box_distribution.h"
#include "arbox/heads/references.h"

namespace arbox::heads {

/// p(b | h) as a product of conditionals (paper, section 3.1). A draw's density is that of its
/// vector, log_density(boxes) that of the boxes: it sums over the distinct equivalent vectors, and
/// is -infinity where all of them lie outside of the codec's ranges. mean() is estimated from 256
/// draws whose random numbers are the same for every object.
class AutoregressiveDistribution : public BoxDistribution {
 public:
  /// `inputs` (N, C + E) float32: features and condition side by side. `known` (N, k): values of
  /// the first k components, or undefined.
  AutoregressiveDistribution(std::shared_ptr<const AutoregressiveModel> model, at::Tensor inputs,
                             References references, at::Tensor known = {});

  std::int64_t size() const override { return inputs_.size(0); }
  Measure measure() const override { return Measure::kDensity; }
  Draws mode(const ModeOptions& options) const override;
  Draws sample(int count, const Streams& streams, double temperature) const override;
  at::Tensor mean() const override;
  at::Tensor log_density(const at::Tensor& boxes) const override;
  std::unique_ptr<BoxDistribution> select(const at::Tensor& index) const override;
  std::unique_ptr<BoxDistribution> given_sizes(const at::Tensor& sizes) const override;
  at::Tensor log_size_density(const at::Tensor& sizes) const override;

  /// (N, M, D) values of vectors that lie on bins -> (N, M): log probability of the bins of the
  /// components that are not known.
  at::Tensor log_probability(const at::Tensor& values) const;

 private:
  std::int32_t known_count() const;
  at::Tensor score(const at::Tensor& values, std::int32_t first, std::int32_t last) const;
  at::Tensor values_of_sizes(const at::Tensor& sizes, const char* where) const;

  std::shared_ptr<const AutoregressiveModel> model_;
  at::Tensor inputs_;
  References references_;
  at::Tensor known_;
};

}  // namespace arbox::heads
