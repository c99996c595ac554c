#pragma once

#include "arbox/drawing/image.h"
#include "arbox/evaluation/indoor_protocol.h"
#include "arbox/evaluation/kitti_protocol.h"

namespace arbox::cli {

/// Precision over recall: a panel for each class and metric with a line for each difficulty. A
/// report without curves gives one empty panel.
drawing::Image draw_precision_recall(const evaluation::KittiReport& report);

/// A panel for each of the thresholds 0.25 and 0.50 with a line for each class.
drawing::Image draw_precision_recall(const evaluation::IndoorReport& report);

}  // namespace arbox::cli
