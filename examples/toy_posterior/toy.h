#pragma once

#include <vector>

#include "arbox/heads/box_codec.h"
#include "arbox/heads/box_head.h"

/// \file
/// A small world whose posterior over boxes is known exactly, to see what a head can learn. Every
/// object has a length, a position x and a heading; all else is fixed, and no feature tells one
/// object from another, so that the best a head can do is to learn the joint distribution:
///
/// - bimodal: an object is short (a can) or long (a beam);
/// - correlated: its near face is seen, so that x follows the length;
/// - symmetric: a can has no heading (all equally likely), a beam is along one of two axes.

namespace arbox::examples {

inline constexpr int kLengths = 16, kPositions = 16, kHeadings = 15;

/// Components length, x and yaw of 16 bins each; the yaw is circular with period pi, so that 15 of
/// its bins are distinct.
class ToyCodec : public heads::BoxCodec {
 public:
  ToyCodec();
  std::span<const heads::Component> components() const override { return components_; }
  at::Tensor encode(const at::Tensor& boxes, const heads::References& references) const override;
  at::Tensor decode(const at::Tensor& components,
                    const heads::References& references) const override;
  heads::ComponentSet equivalents(const at::Tensor& boxes,
                                  const heads::References& references) const override;
  std::vector<int> size_components() const override { return {0}; }
  bool upright() const override { return true; }
  at::Tensor encode_sizes(const at::Tensor& sizes,
                          const heads::References& references) const override;

 private:
  std::vector<heads::Component> components_;
};

/// Probabilities of (length, x, yaw), row-major.
using ToyJoint = std::vector<double>;

/// The true joint distribution.
ToyJoint toy_joint();

/// One feature, no condition, and the ToyCodec.
heads::HeadContext toy_context();

/// `count` objects that look the same.
heads::HeadInput toy_input(std::int64_t count);

/// (count, 10) boxes drawn from a joint distribution.
at::Tensor draw_boxes(const ToyJoint& joint, std::int64_t count, std::uint64_t seed);

/// Fits a head to fresh draws from the true joint with Adam, its rate falling to zero.
void fit(heads::BoxHead& head, int steps, std::int64_t batch);

/// What a fitted head believes: its density at every cell, normalised.
ToyJoint joint_of(heads::BoxHead& head);

/// Half the sum of absolute differences: 0 for equal distributions, 1 for disjoint ones.
double total_variation(const ToyJoint& first, const ToyJoint& second);

}  // namespace arbox::examples
