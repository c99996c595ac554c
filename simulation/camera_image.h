#pragma once

#include <cstdint>
#include <vector>

#include "arbox/base/option_field.h"
#include "arbox/drawing/image.h"
#include "arbox/simulation/kitti_cameras.h"
#include "arbox/simulation/scene.h"

namespace arbox::simulation {

/// How pictures are rendered.
struct CameraImageOptions {
  /// Rays of a pixel along each of its sides; the cost grows with the square.
  int samples = 2;

  template <class Visitor>
  static void describe(Visitor& visitor) {
    visitor.field("samples", &CameraImageOptions::samples,
                  {.help = "Rays along each side of a pixel: 1 is rough, 2 has smooth edges",
                   .low = 1,
                   .high = 8});
  }
};

/// What the left colour camera sees.
struct CameraImage {
  drawing::Image picture;
  /// For each pixel, row by row, the index into Scene::objects of what its first ray meets, panes
  /// included; -1 for the rest of the world and the sky.
  std::vector<std::int32_t> objects;
};

/// A simple picture of the scene at its reference time (the moment when the scanner looks forward):
/// colours by material and object, sun and shadows, sky light, tinted panes, paint on the road, and
/// some haze. Pixel (x, y) has its middle at the image coordinates (x, y), as in the labels.
///
/// Colours and daylight are drawn from streams of their own of `scene.seed`: neither scans nor
/// labels depend on them. Equal scenes give equal bytes. Runs on the caller's thread, about 1.6 s
/// for 1242 x 375 pixels with 2 x 2 rays each, 0.45 s with one. Throws ConfigError for options out
/// of range, InvalidArgument for an image without pixels or beyond 16384 a side.
CameraImage render_camera_image(const Scene& scene, const CameraView& camera,
                                const CameraImageOptions& options = {});

}  // namespace arbox::simulation
