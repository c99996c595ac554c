#pragma once

#include <memory>
#include <vector>

#include "arbox/base/option_field.h"
#include "arbox/heads/box_head.h"
#include "arbox/heads/point_loss.h"

namespace arbox::heads {

class MultilayerPerceptron;

struct FourPointOptions {
  std::vector<std::int64_t> hidden = {128, 256, 512};
  PointLoss loss = PointLoss::kL1;
  double beta = 1.0;

  template <class Visitor>
  static void describe(Visitor& visitor) {
    visitor.field("hidden", &FourPointOptions::hidden,
                  {.help = "Widths of the hidden layers", .low = 1, .high = 65536});
    visitor.field("loss", &FourPointOptions::loss,
                  {.help = "Loss of a coordinate", .choices = {"l1", "smooth_l1"}});
    visitor.field("beta", &FourPointOptions::beta,
                  {.help = "Where smooth_l1 turns linear, in reference sizes", .low = 1e-9});
  }
};

/// Predicts a corner and its three neighbours (the 4-point baseline of the paper, section 5): 12
/// coordinates in the references' frame over the references' largest size, from the corners of the
/// reference box. Gram-Schmidt makes a box of them. Parameters: layers.{0,2,...}.{weight,bias}.
///
/// Loss: mean over the 12 coordinates, against the nearest of the 24 ways to name four corners of
/// the target in a right-handed order. The 24 mirrored ways that the paper's code also allows name
/// a reflection of the box, which no rotation reaches; they are not used. It needs no codec: which
/// axis is the length has no meaning here, so that known sizes are refused and headings are lost.
class FourPointHead : public BoxHead {
 public:
  /// Throws ConfigError for options out of range.
  FourPointHead(FourPointOptions options, HeadContext context);

  std::unique_ptr<BoxDistribution> forward(const HeadInput& input) override;
  HeadLoss loss(const HeadInput& input, const at::Tensor& target_boxes) override;

  /// (N, 4, 3) corners in the references' frame over their largest size.
  at::Tensor corners(const HeadInput& input) const;

 private:
  FourPointOptions options_;
  HeadContext context_;
  std::shared_ptr<MultilayerPerceptron> layers_;
};

/// Boxes (N, 10) -> (N, 24, 4, 3): each right-handed choice of a corner and its three neighbours,
/// in the references' frame over their largest size.
at::Tensor corner_assignments(const at::Tensor& boxes, const References& references);

/// The box of four points (N, 4, 3) by Gram-Schmidt: (N, 10). The centre is that of the
/// parallelepiped; sizes are at least 1 mm.
at::Tensor box_of_corners(const at::Tensor& points, const References& references);

}  // namespace arbox::heads
