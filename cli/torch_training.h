#pragma once

#include "arbox/cli/torch_module.h"

namespace arbox::cli {

/// Makes training::PvRcnnTraining.
OptionsInstance make_training_options();

/// TorchModule::train.
TrainOutcome train(const TrainRequest& request);

}  // namespace arbox::cli
