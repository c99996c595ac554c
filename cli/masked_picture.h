#pragma once

#include "arbox/drawing/image.h"
#include "arbox/io/labeled_scene.h"

namespace arbox::cli {

/// The colours of a depth camera, or its depths in grey, with what is seen of each object tinted
/// and the outline of all of it, hidden parts too.
drawing::Image masked_picture(const io::RgbdImages& images);

}  // namespace arbox::cli
