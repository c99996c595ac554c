#pragma once

#include "arbox/drawing/image.h"
#include "arbox/training/train_log.h"

namespace arbox::training {

/// The course of a run: loss and its terms, gradient norm, learning rate and momentum, and figures
/// of the validations, over steps. Loss curves are running medians where there are more steps than
/// the picture can show.
drawing::Image draw_training(const TrainHistory& history);

}  // namespace arbox::training
