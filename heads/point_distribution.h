#pragma once

#include <memory>

#include "arbox/heads/box_codec.h"
#include "arbox/heads/box_distribution.h"

namespace arbox::heads {

/// What a head without a likelihood believes: one box. Samples repeat it and measure() is kNone, so
/// that quantile boxes are that box and uncertainties 0, and callers can tell.
class PointDistribution : public BoxDistribution {
 public:
  /// Boxes (N, 10) that no codec describes; known sizes are refused.
  explicit PointDistribution(at::Tensor boxes);

  /// Components (N, D); known sizes replace those of the sizes.
  PointDistribution(const at::Tensor& components, std::shared_ptr<const BoxCodec> codec,
                    const References& references);

  std::int64_t size() const override { return boxes_.size(0); }
  Measure measure() const override { return Measure::kNone; }
  Draws mode(const ModeOptions& options) const override;
  Draws sample(int count, const Streams& streams, double temperature) const override;
  at::Tensor mean() const override { return boxes_; }
  at::Tensor log_density(const at::Tensor& boxes) const override;
  std::unique_ptr<BoxDistribution> select(const at::Tensor& index) const override;
  std::unique_ptr<BoxDistribution> given_sizes(const at::Tensor& sizes) const override;

 private:
  Draws repeated(std::int64_t count) const;

  at::Tensor boxes_;
  at::Tensor components_;  // (N, D) or undefined
  std::shared_ptr<const BoxCodec> codec_;
  References references_;
};

}  // namespace arbox::heads
