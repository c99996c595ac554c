#pragma once

#include <string>
#include <vector>

#include "arbox/base/option_field.h"
#include "arbox/heads/box_codec.h"

/// \file
/// Codecs of boxes that stand upright. Roll and pitch of boxes given to encode are ignored.

namespace arbox::heads {

/// What the upright codecs share.
struct YawCodecOptions {
  /// The order of prediction: "size_center_rotation" (the paper's) or "center_size_rotation" (its
  /// KITTI weights).
  std::string order = "size_center_rotation";
  int bins = 512;
  double size_low = 0.0, size_high = 0.0;
  double center_low = 0.0, center_high = 0.0;
  /// Headings over a whole turn; otherwise modulo half a turn.
  bool full_turn = false;
  /// The box with its heading turned by half is another vector of the same box (full_turn only: it
  /// is the same vector otherwise).
  bool half_turn_equivalent = false;
  /// Length and width swapped with a quarter turn is another vector of the same box.
  bool quarter_turn_equivalent = false;

  template <class Visitor>
  static void describe(Visitor& visitor) {
    visitor.field("order", &YawCodecOptions::order,
                  {.help = "Order of prediction",
                   .choices = {"size_center_rotation", "center_size_rotation"}});
    visitor.field("bins", &YawCodecOptions::bins,
                  {.help = "Bins of a component", .low = 2, .high = 65536});
    visitor.field("size_low", &YawCodecOptions::size_low, {.help = "Lowest bin of sizes"});
    visitor.field("size_high", &YawCodecOptions::size_high, {.help = "Highest bin of sizes"});
    visitor.field("center_low", &YawCodecOptions::center_low, {.help = "Lowest bin of centres"});
    visitor.field("center_high", &YawCodecOptions::center_high, {.help = "Highest bin of centres"});
    visitor.field("full_turn", &YawCodecOptions::full_turn,
                  {.help = "Headings over a whole turn, not modulo half a turn"});
    visitor.field("half_turn_equivalent", &YawCodecOptions::half_turn_equivalent,
                  {.help = "A box turned by half is the same box"});
    visitor.field("quarter_turn_equivalent", &YawCodecOptions::quarter_turn_equivalent,
                  {.help = "Length and width swapped with a quarter turn is the same box"});
  }
};

/// Order, ranges and equivalent vectors of a centre, a size and a heading; the two codecs below say
/// how each number is measured.
class YawCodec : public BoxCodec {
 public:
  std::span<const Component> components() const override { return components_; }
  at::Tensor encode(const at::Tensor& boxes, const References& references) const override;
  at::Tensor decode(const at::Tensor& components, const References& references) const override;
  ComponentSet equivalents(const at::Tensor& boxes, const References& references) const override;
  std::vector<int> size_components() const override;
  bool upright() const override { return true; }
  at::Tensor encode_sizes(const at::Tensor& sizes, const References& references) const override;
  const YawCodecOptions& options() const { return options_; }

 protected:
  /// with_yaw = false leaves the heading out (D = 6): boxes are axis-aligned in the references'
  /// frame. `yaw_low` is the lowest heading.
  YawCodec(YawCodecOptions options, bool with_yaw, double yaw_low);

 private:
  /// (N, 3) centre in the references' frame -> (N, 3) numbers, and back.
  virtual at::Tensor encode_center(const at::Tensor& local, const References& references) const = 0;
  virtual at::Tensor decode_center(const at::Tensor& values,
                                   const References& references) const = 0;
  virtual at::Tensor encode_size(const at::Tensor& sizes, const References& references) const = 0;
  virtual at::Tensor decode_size(const at::Tensor& values, const References& references) const = 0;

  at::Tensor join(const at::Tensor& size, const at::Tensor& center, const at::Tensor& yaw) const;

  YawCodecOptions options_;
  bool with_yaw_;
  double yaw_low_, yaw_period_;
  bool size_first_;
  std::vector<Component> components_;
};

/// Residuals to a region of interest, as PV-RCNN codes them (docs/heads.md): with the RoI's
/// l, w, h and its diagonal d = sqrt(l^2 + w^2), the centre in the RoI's frame as x / d, y / d,
/// z / h, the log ratios of the sizes, and the difference of headings in [-pi/2, pi/2] (a RoI's
/// direction is decided before) or, with full_turn, in [-pi, pi]. Sizes below 1e-5 m are taken as
/// 1e-5 m.
class ResidualCodec : public YawCodec {
 public:
  static YawCodecOptions defaults() {
    return {.size_low = -0.5, .size_high = 0.5, .center_low = -0.5, .center_high = 0.5};
  }
  explicit ResidualCodec(YawCodecOptions options = defaults());

 private:
  at::Tensor encode_center(const at::Tensor& local, const References& references) const override;
  at::Tensor decode_center(const at::Tensor& values, const References& references) const override;
  at::Tensor encode_size(const at::Tensor& sizes, const References& references) const override;
  at::Tensor decode_size(const at::Tensor& values, const References& references) const override;
};

/// Sizes and centre offsets over a predicted scale s = references.size[:, 0], as the paper's FCAF3D
/// head codes them: size / s, (centre - origin) / s, heading in [0, pi], or [0, 2 pi] with
/// full_turn. Without yaw D = 6.
class ScaledCodec : public YawCodec {
 public:
  static YawCodecOptions defaults() {
    return {.size_low = 0.0, .size_high = 3.0, .center_low = -1.0, .center_high = 1.0};
  }
  explicit ScaledCodec(YawCodecOptions options = defaults(), bool with_yaw = true);

 private:
  at::Tensor encode_center(const at::Tensor& local, const References& references) const override;
  at::Tensor decode_center(const at::Tensor& values, const References& references) const override;
  at::Tensor encode_size(const at::Tensor& sizes, const References& references) const override;
  at::Tensor decode_size(const at::Tensor& values, const References& references) const override;
};

}  // namespace arbox::heads
