#pragma once

#include "arbox/drawing/curves.h"
#include "arbox/drawing/internal/canvas.h"

namespace arbox::drawing {

/// Draws a valid panel with its axes, labels and legend into a rectangle of the canvas.
void draw_panel(Canvas& canvas, const Panel& panel, const Rect& room);

}  // namespace arbox::drawing
