#pragma once

#include <optional>
#include <string>
#include <vector>

#include "arbox/base/option_field.h"
#include "arbox/heads/box_codec.h"

namespace arbox::heads {

struct QuartileCodecOptions {
  /// The order of prediction: "size_center_rotation" (the paper's) or "center_size_rotation".
  std::string order = "size_center_rotation";
  int bins = 512;
  /// Full sizes over s. The paper's weights have half sizes in [0, 11]: the same bins.
  double size_low = 0.0, size_high = 22.0;
  double center_low = -8.0, center_high = 11.0;
  /// Highest bin of beta. Without it an even number of bins ends one step beyond pi, so that pi / 2
  /// is a bin: with pi it lies half way between two, and the labels of boxes that stand or lie
  /// squarely in the frame are left to rounding. The paper's weights have pi.
  std::optional<double> beta_high = {};
  /// Which of the 24 (size, rotation) pairs of one box are supervised: "canonical" takes one choice
  /// of axis signs for each of the 6 orders of axes (paper's code), "all" takes the 24, "one" the
  /// canonical signs of the order that was given.
  std::string equivalents = "canonical";

  template <class Visitor>
  static void describe(Visitor& visitor) {
    visitor.field("order", &QuartileCodecOptions::order,
                  {.help = "Order of prediction",
                   .choices = {"size_center_rotation", "center_size_rotation"}});
    visitor.field("bins", &QuartileCodecOptions::bins,
                  {.help = "Bins of a component", .low = 2, .high = 65536});
    visitor.field("size_low", &QuartileCodecOptions::size_low, {.help = "Lowest bin of sizes"});
    visitor.field("size_high", &QuartileCodecOptions::size_high, {.help = "Highest bin of sizes"});
    visitor.field("center_low", &QuartileCodecOptions::center_low,
                  {.help = "Lowest bin of centres"});
    visitor.field("center_high", &QuartileCodecOptions::center_high,
                  {.help = "Highest bin of centres"});
    visitor.field("beta_high", &QuartileCodecOptions::beta_high,
                  {.help = "Highest bin of beta", .unit = "rad", .low = 3, .high = 7});
    visitor.field(
        "equivalents", &QuartileCodecOptions::equivalents,
        {.help = "Vectors of one box that are supervised", .choices = {"canonical", "all", "one"}});
  }
};

/// Boxes of any rotation in the quartile frame of a crop (paper, section 3.2.2): size / s,
/// (centre - origin) / s with s = references.size[:, 0], and the ZYZ angles of the rotation in the
/// references' frame, R = Rz(alpha) Ry(beta) Rz(gamma), alpha and gamma in [0, 2 pi] (circular),
/// beta in [0, pi] (its bins end at beta_high). D = 9: length width height x y z alpha beta gamma
/// (the centre first by option).
///
/// The canonical signs of an order of axes are those with R[1][0] > 0 and R[2][1] > 0 as far as the
/// four choices can have it; ties take the first, so that the set is never empty.
class QuartileCodec : public BoxCodec {
 public:
  explicit QuartileCodec(QuartileCodecOptions options = {});

  std::span<const Component> components() const override { return components_; }
  at::Tensor encode(const at::Tensor& boxes, const References& references) const override;
  at::Tensor decode(const at::Tensor& components, const References& references) const override;
  ComponentSet equivalents(const at::Tensor& boxes, const References& references) const override;
  std::vector<int> size_components() const override;
  bool upright() const override { return false; }
  at::Tensor encode_sizes(const at::Tensor& sizes, const References& references) const override;

 private:
  bool size_first() const { return options_.order == "size_center_rotation"; }

  QuartileCodecOptions options_;
  std::vector<Component> components_;
};

}  // namespace arbox::heads
