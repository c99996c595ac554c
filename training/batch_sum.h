#pragma once

#include <ATen/core/Tensor.h>

#include <map>
#include <string>
#include <vector>

#include "arbox/training/communicator.h"

namespace arbox::training {

/// What the processes tell each other once a step, beside gradients.
struct BatchFigures {
  double loss = 0;
  std::map<std::string, double> terms;
  /// Processes that ask for the end of the run, and those whose time is over.
  int stops = 0;
  int late = 0;
};

/// Replaces gradients (an absent one counts as 0) and figures by their sums over the processes.
/// Terms stay this process's own where the processes name different ones.
void sum_batch(const std::vector<at::Tensor>& parameters, BatchFigures& figures,
               Communicator& processes);

/// Replaces tensors by those of process 0. Every process must call it with the same shapes.
void share_from_first(const std::vector<at::Tensor>& tensors, Communicator& processes);

}  // namespace arbox::training
