#pragma once

#include "arbox/detectors/pv_rcnn/options.h"

namespace arbox::training {

/// A PV-RCNN that is small enough to learn in seconds: 51.2 x 51.2 m, for cars and pedestrians.
inline detectors::pv_rcnn::Options tiny_network() {
  detectors::pv_rcnn::Options options;
  options.classes = {"Car", "Pedestrian"};
  options.voxels.low = {-25.6, -25.6, -3.2};
  options.voxels.high = {25.6, 25.6, 1.6};
  options.voxels.size = {0.2, 0.2, 0.3};
  options.voxels.max_points_per_voxel = 0;
  options.voxels.max_voxels_training = options.voxels.max_voxels = 0;
  options.backbone.channels = {16, 16};
  options.backbone.layers = {1, 1};
  options.backbone.down_kernel = 2;
  options.backbone.vertical_padding = {};
  options.backbone.height_margin = 0;
  options.backbone.out_channels = 32;
  options.backbone.out_kernel = options.backbone.out_stride = 8;
  options.birds_eye.sparse = true;
  options.birds_eye.channels = {32, 32};
  options.birds_eye.layers = {2, 2};
  options.birds_eye.strides = {1, 2};
  options.birds_eye.up_channels = {32, 32};
  options.anchors.lengths = {3.9, 0.8};
  options.anchors.widths = {1.6, 0.6};
  options.anchors.heights = {1.56, 1.73};
  options.anchors.bottoms = {-1.78, -1.7};
  options.anchors.positive_iou = {0.6, 0.5};
  options.anchors.negative_iou = {0.45, 0.35};
  options.anchors.on_borders = false;
  options.training_proposals = {.candidates = 512, .iou = 0.8, .count = 128};
  options.proposals = {.candidates = 256, .iou = 0.7, .count = 32};
  options.keypoints.count = 512;
  options.keypoints.around = "proposals";
  options.keypoints.birds_eye = "after";
  options.keypoints.points = {{0.8}, {16}, {16, 16}};
  options.keypoints.level1 = options.keypoints.level3 = options.keypoints.level4 = {{}, {}, {}};
  options.keypoints.level2 = {{1.6}, {16}, {32}};
  options.keypoints.fused = 32;
  options.keypoints.weighting = {32};
  options.regions.grid = 4;
  options.regions.pooling = {{1.2}, {16}, {32}};
  options.regions.shared = {128};
  options.regions.confidence = {64};
  options.regions.residuals = {64};
  options.regions.dropout = 0;
  return options;
}

}  // namespace arbox::training
