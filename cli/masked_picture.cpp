#include "arbox/cli/masked_picture.h"

#include <algorithm>

#include "arbox/drawing/color.h"

namespace arbox::cli {
namespace {

drawing::Image colors_of(const io::RgbdImages& images) {
  drawing::Image picture(images.width, images.height, {});
  const float farthest = *std::max_element(images.depth.begin(), images.depth.end());
  float nearest = farthest;
  for (const float depth : images.depth) nearest = depth > 0 ? std::min(nearest, depth) : nearest;
  for (std::size_t i = 0; i < images.depth.size(); ++i) {
    for (std::size_t c = 0; c < 3; ++c) {
      const float share = (farthest - images.depth[i]) / std::max(farthest - nearest, 1e-6F);
      const auto grey = static_cast<std::uint8_t>(images.depth[i] > 0 ? 60 + 180 * share : 0);
      picture.pixels[3 * i + c] = images.rgb.empty() ? grey : images.rgb[3 * i + c];
    }
  }
  return picture;
}

/// True for a pixel of the mask beside one that is not.
bool on_edge(const std::vector<std::uint8_t>& mask, int width, int height, int x, int y) {
  const auto is_set = [&](int u, int v) {
    return u >= 0 && v >= 0 && u < width && v < height &&
           mask[static_cast<std::size_t>(v) * static_cast<std::size_t>(width) +
                static_cast<std::size_t>(u)] != 0;
  };
  return is_set(x, y) &&
         !(is_set(x - 1, y) && is_set(x + 1, y) && is_set(x, y - 1) && is_set(x, y + 1));
}

}  // namespace

drawing::Image masked_picture(const io::RgbdImages& images) {
  drawing::Image picture = colors_of(images);
  for (std::size_t n = 0; n < images.amodal_masks.size(); ++n) {
    const drawing::Color tint = drawing::palette_color(static_cast<int>(n));
    for (std::size_t i = 0; i < images.depth.size(); ++i) {
      const auto pixel = static_cast<int>(i);
      const bool edge = on_edge(images.amodal_masks[n], images.width, images.height,
                                pixel % images.width, pixel / images.width);
      const double strength = edge ? 0.85 : images.visible_masks[n][i] != 0 ? 0.35 : 0.0;
      if (strength == 0.0) continue;
      std::uint8_t* color = picture.pixels.data() + 3 * i;
      const drawing::Color mixed = drawing::mix({color[0], color[1], color[2]}, tint, strength);
      color[0] = mixed.r, color[1] = mixed.g, color[2] = mixed.b;
    }
  }
  return picture;
}

}  // namespace arbox::cli
