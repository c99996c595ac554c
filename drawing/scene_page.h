#pragma once

#include <string>
#include <vector>

#include "arbox/drawing/scene.h"

namespace arbox::drawing {

/// The quantile boxes to step through, by rising q: of detections with samples those at 0.05, 0.10
/// and so on to 0.95, of others those that they have.
std::vector<geometry::QuantileBox> quantile_steps(const geometry::Detection& detection);

/// The scene as one HTML page that needs no network and no other file: the cloud with its boxes to
/// turn, move and zoom, a slider that steps through the quantile boxes (quantile_steps), and a
/// box's details under the pointer.
///
/// Of the options colour, background, title, minimum_score and captions are used, and range,
/// azimuth and elevation say where the camera stands at first. Photos are left out. Of more than
/// `most_points` points every n-th is kept, which the page tells. Positions are rounded to 1/65535
/// of the cloud's extent (1 to 3 mm for a LiDAR scan).
///
/// About 12 bytes a point. Equal input gives equal bytes. Throws as draw_scene does.
std::string scene_page(const Scene& scene, const SceneOptions& options = {},
                       std::size_t most_points = 400000);

}  // namespace arbox::drawing
