#pragma once

#include <memory>
#include <vector>

#include "arbox/heads/box_codec.h"
#include "arbox/heads/box_distribution.h"

namespace arbox::heads {

/// What distributions whose components are independent share: a codec, references, and known sizes,
/// which leave the other components as they are. log_size_density() is the product of the densities
/// of the size components, known or not.
class IndependentDistribution : public BoxDistribution {
 public:
  std::int64_t size() const override { return references_.count(); }
  Measure measure() const override { return Measure::kDensity; }
  std::unique_ptr<BoxDistribution> select(const at::Tensor& index) const override;
  std::unique_ptr<BoxDistribution> given_sizes(const at::Tensor& sizes) const override;
  at::Tensor log_size_density(const at::Tensor& sizes) const override;

 protected:
  IndependentDistribution(std::shared_ptr<const BoxCodec> codec, const References& references);

  const BoxCodec& codec() const { return *codec_; }
  const References& references() const { return references_; }
  bool is_known(int component) const;
  /// values (N, K, D) with the known sizes in their place.
  at::Tensor with_known(const at::Tensor& values) const;
  /// mask (N, M) of the vectors (N, M, D) that have the known sizes.
  at::Tensor of_known(const at::Tensor& values, const at::Tensor& mask) const;

 private:
  virtual std::unique_ptr<IndependentDistribution> clone() const = 0;
  virtual void keep_rows(const at::Tensor& index) = 0;
  /// values (N, 1, D) -> (N): log density of the components in `of`.
  virtual at::Tensor density_of(const at::Tensor& values, const std::vector<int>& of) const = 0;

  at::Tensor values_of(const at::Tensor& sizes, const char* where) const;

  std::shared_ptr<const BoxCodec> codec_;
  References references_;
  at::Tensor sizes_;  // (N, 3) known values of the size components, or undefined
};

}  // namespace arbox::heads
