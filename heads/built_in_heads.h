#pragma once

#include <array>

/// \file
/// Names of the built-in heads, for whoever lists them without loading LibTorch.

namespace arbox::heads {

struct BuiltInHead {
  const char* name;
  const char* help;
};

inline constexpr BuiltInHead kAutoregressive = {
    "autoregressive", "Bins of each component, given those before: any distribution"};
inline constexpr BuiltInHead kDiscrete = {"discrete",
                                          "Bins of each component, independent of the others"};
inline constexpr BuiltInHead kFourPoint = {"four_point",
                                           "A corner and its neighbours: one box, any rotation"};
inline constexpr BuiltInHead kGaussian = {"gaussian",
                                          "Mean and variance of each component, independent"};
inline constexpr BuiltInHead kPointwise = {"pointwise", "One value of each component: one box"};

inline constexpr std::array kBuiltInHeads = {kAutoregressive, kDiscrete, kFourPoint, kGaussian,
                                             kPointwise};

}  // namespace arbox::heads
