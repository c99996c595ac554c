#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "arbox/detectors/pv_rcnn/network.h"
#include "arbox/evaluation/kitti_protocol.h"
#include "arbox/geometry/detection.h"
#include "arbox/training/scene.h"

/// \file
/// How well a network under training does on scenes in memory.

namespace arbox::training::pv_rcnn {

/// Labels and detections of a scene for evaluate_kitti. A scene does not know of images, so the
/// labels get a height in the image, an occlusion and a truncation that the protocol takes for
/// their difficulty, detections count whatever their size in the image, and figures of the image
/// mean nothing. Other objects that resemble a class get the name of kitti_classes()' neighbour.
/// Objects and detections outside of the range `low` to `high` (centres) are left out.
evaluation::KittiFrame to_kitti_frame(const Scene& scene,
                                      std::span<const geometry::Detection> detections,
                                      const detectors::pv_rcnn::Options& options);

/// Each class with the benchmark's overlaps (0.5 for classes that it does not know), and
/// "other CLASS" as its neighbour.
std::vector<evaluation::KittiClass> kitti_classes(const std::vector<std::string>& classes);

/// How well each head detects with the network's options (pv_rcnn.h). By head: "CLASS 3d R40
/// DIFFICULTY", "CLASS bev R40 DIFFICULTY" in percent, and "CLASS found", the mean over the objects
/// (those harder than hard left out) of the IoU with the best detection of the class; 0 where a
/// class has no objects. Scenes are read one after the other. Puts the network into eval mode.
std::map<std::string, std::map<std::string, double>> evaluate_heads(
    const std::shared_ptr<detectors::pv_rcnn::Network>& network, const SceneSource& scenes);

}  // namespace arbox::training::pv_rcnn
