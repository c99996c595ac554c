#pragma once

#include <cstdint>

namespace arbox::training {

/// Learning rate and momentum over a run (Smith, "Super-convergence", 2017; cosine phases): the
/// rate rises from learning_rate / start_divisor to learning_rate over the first part of the steps
/// and then falls to learning_rate / end_divisor, while momentum falls and rises again.
struct OneCycleOptions {
  double learning_rate = 0.01;
  double start_divisor = 10;
  double end_divisor = 1e5;
  double rise = 0.4;
  double momentum_high = 0.95;
  double momentum_low = 0.85;

  template <class Visitor>
  static void describe(Visitor& visitor) {
    visitor.field("learning_rate", &OneCycleOptions::learning_rate,
                  {.help = "Highest learning rate", .low = 0, .high = 100});
    visitor.field(
        "start_divisor", &OneCycleOptions::start_divisor,
        {.help = "The run begins with learning_rate divided by this", .low = 1, .high = 1e12});
    visitor.field(
        "end_divisor", &OneCycleOptions::end_divisor,
        {.help = "The run ends with learning_rate divided by this", .low = 1, .high = 1e12});
    visitor.field("rise", &OneCycleOptions::rise,
                  {.help = "Share of the steps over which the rate rises", .low = 0, .high = 1});
    visitor.field("momentum_high", &OneCycleOptions::momentum_high,
                  {.help = "Momentum at both ends", .low = 0, .high = 0.9999});
    visitor.field("momentum_low", &OneCycleOptions::momentum_low,
                  {.help = "Momentum where the rate is highest", .low = 0, .high = 0.9999});
  }
};

struct CyclePoint {
  double learning_rate = 0;
  double momentum = 0;
};

/// Where the cycle stands before step number `step` (from 0) of `steps` >= 1; a later step gets the
/// end. The rise takes floor(rise * steps) steps.
CyclePoint one_cycle(const OneCycleOptions& options, std::int64_t step, std::int64_t steps);

}  // namespace arbox::training
