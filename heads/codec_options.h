#pragma once

#include <memory>
#include <optional>
#include <string>

#include "arbox/base/option_field.h"
#include "arbox/heads/box_codec.h"

namespace arbox::heads {

/// Any of the codecs, as a configuration names it.
struct CodecOptions {
  /// residual (PV-RCNN, yaw_codecs.h), scaled (FCAF3D, yaw_codecs.h) or quartile (crops,
  /// quartile_codec.h).
  std::string kind = "residual";
  int bins = 512;
  /// Ranges; those of the codec where not given (`arbox config fit-bins` finds them for a data
  /// set).
  std::optional<double> size_low, size_high, center_low, center_high;
  std::string order = "size_center_rotation";
  /// Upright codecs.
  bool with_yaw = true;
  bool full_turn = false;
  bool half_turn_equivalent = false;
  bool quarter_turn_equivalent = false;
  /// The quartile codec.
  std::optional<double> beta_high;
  std::string equivalents = "canonical";

  template <class Visitor>
  static void describe(Visitor& visitor) {
    visitor.field(
        "kind", &CodecOptions::kind,
        {.help = "How boxes become numbers", .choices = {"residual", "scaled", "quartile"}});
    visitor.field("bins", &CodecOptions::bins,
                  {.help = "Bins of a component", .low = 2, .high = 65536});
    visitor.field("size_low", &CodecOptions::size_low, {.help = "Lowest bin of sizes"});
    visitor.field("size_high", &CodecOptions::size_high, {.help = "Highest bin of sizes"});
    visitor.field("center_low", &CodecOptions::center_low, {.help = "Lowest bin of centres"});
    visitor.field("center_high", &CodecOptions::center_high, {.help = "Highest bin of centres"});
    visitor.field("order", &CodecOptions::order,
                  {.help = "Order of prediction",
                   .choices = {"size_center_rotation", "center_size_rotation"}});
    visitor.field("with_yaw", &CodecOptions::with_yaw,
                  {.help = "Predict a heading (scaled; the others always do)"});
    visitor.field("full_turn", &CodecOptions::full_turn,
                  {.help = "Headings over a whole turn, not half of one (residual, scaled)"});
    visitor.field("half_turn_equivalent", &CodecOptions::half_turn_equivalent,
                  {.help = "A box turned by half is the same box (residual, scaled)"});
    visitor.field(
        "quarter_turn_equivalent", &CodecOptions::quarter_turn_equivalent,
        {.help = "Length and width swapped with a quarter turn is the same (residual, scaled)"});
    visitor.field("beta_high", &CodecOptions::beta_high,
                  {.help = "Highest bin of beta (quartile); pi for the paper's weights",
                   .unit = "rad",
                   .low = 3,
                   .high = 7});
    visitor.field("equivalents", &CodecOptions::equivalents,
                  {.help = "Vectors of one box that are supervised (quartile)",
                   .choices = {"canonical", "all", "one"}});
  }
};

/// Throws ConfigError for values that the codec refuses.
std::shared_ptr<const BoxCodec> make_codec(const CodecOptions& options);

}  // namespace arbox::heads
