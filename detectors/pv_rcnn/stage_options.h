#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "arbox/base/option_field.h"

/// \file
/// Sizes of PV-RCNN's stages up to the keypoints. Defaults are the published KITTI network's.

namespace arbox::detectors::pv_rcnn {

/// What part of the world is looked at, and how points become voxels.
struct VoxelOptions {
  /// Corners of the range, metres: x forward, y left, z up.
  std::array<double, 3> low{0, -40, -3}, high{70.4, 40, 1};
  std::array<double, 3> size{0.05, 0.05, 0.1};
  int max_points_per_voxel = 5;
  int max_voxels_training = 16000, max_voxels = 40000;
  /// Points of a scan that take part, chosen evenly over the scan if there are more.
  int max_points = 1000000;

  template <class Visitor>
  static void describe(Visitor& visitor) {
    using Self = VoxelOptions;
    visitor.field("low", &Self::low,
                  {.help = "Lowest corner of the range", .unit = "m", .low = -1000, .high = 1000});
    visitor.field("high", &Self::high,
                  {.help = "Highest corner of the range", .unit = "m", .low = -1000, .high = 1000});
    visitor.field("size", &Self::size,
                  {.help = "Edges of a voxel", .unit = "m", .low = 0.005, .high = 10});
    visitor.field("max_points_per_voxel", &Self::max_points_per_voxel,
                  {.help = "Points of a voxel that count, first come first served; 0 for all",
                   .unit = "points",
                   .low = 0});
    visitor.field("max_voxels_training", &Self::max_voxels_training,
                  {.help = "Voxels of a scan in training, first come first served; 0 for all",
                   .unit = "voxels",
                   .low = 0});
    visitor.field("max_voxels", &Self::max_voxels,
                  {.help = "Voxels of a scan in detection, first come first served; 0 for all",
                   .unit = "voxels",
                   .low = 0});
    visitor.field("max_points", &Self::max_points,
                  {.help = "Points of a scan that take part, evenly chosen if there are more",
                   .unit = "points",
                   .low = 1});
  }

  /// Voxels along x, y, z.
  std::array<int, 3> grid() const;
};

/// The sparse 3-D backbone: levels of stride 1, 2, 4, ...
struct BackboneOptions {
  std::vector<std::int64_t> channels = {16, 32, 64, 64};
  /// Convolutions of each level after the input's; from the second level on the first one halves
  /// the resolution.
  std::vector<std::int64_t> layers = {1, 3, 3, 3};
  /// Kernel of the convolutions that halve the resolution: 3 (padded by 1) or 2.
  int down_kernel = 3;
  /// Vertical padding of those of kernel 3, from the second level on.
  std::vector<std::int64_t> vertical_padding = {1, 1, 0};
  /// Empty cells above the range (spconv's configurations have one).
  int height_margin = 1;
  /// The last convolution, which works along z alone.
  std::int64_t out_channels = 128;
  int out_kernel = 3, out_stride = 2;

  template <class Visitor>
  static void describe(Visitor& visitor) {
    using Self = BackboneOptions;
    visitor.field("channels", &Self::channels,
                  {.help = "Channels of the levels", .low = 1, .high = 4096});
    visitor.field("layers", &Self::layers,
                  {.help = "Convolutions of each level", .low = 1, .high = 64});
    visitor.field("down_kernel", &Self::down_kernel,
                  {.help = "Kernel of the convolutions that halve the resolution: 2 activates no "
                           "cell without input, 3 does",
                   .low = 2,
                   .high = 3});
    visitor.field("vertical_padding", &Self::vertical_padding,
                  {.help = "Vertical padding of those of kernel 3", .low = 0, .high = 1});
    visitor.field("height_margin", &Self::height_margin,
                  {.help = "Empty cells above the range", .unit = "cells", .low = 0, .high = 16});
    visitor.field("out_channels", &Self::out_channels,
                  {.help = "Channels of a cell seen from above", .low = 1, .high = 4096});
    visitor.field(
        "out_kernel", &Self::out_kernel,
        {.help = "Height of the last convolution", .unit = "cells", .low = 1, .high = 64});
    visitor.field("out_stride", &Self::out_stride,
                  {.help = "Vertical stride of the last convolution", .unit = "cells", .low = 1});
  }
};

/// The 2-D backbone over the map seen from above.
struct BirdsEyeOptions {
  /// Work on the cells that hold something and on their neighbours, in place of the whole map.
  bool sparse = false;
  std::vector<std::int64_t> channels = {128, 256};
  /// 3x3 convolutions of each block; the first one has the stride.
  std::vector<std::int64_t> layers = {6, 6};
  std::vector<std::int64_t> strides = {1, 2};
  /// Each block's way back to the first block's resolution: channels there.
  std::vector<std::int64_t> up_channels = {256, 256};

  template <class Visitor>
  static void describe(Visitor& visitor) {
    using Self = BirdsEyeOptions;
    visitor.field("sparse", &Self::sparse,
                  {.help = "Work on occupied cells and their neighbours only"});
    visitor.field("channels", &Self::channels,
                  {.help = "Channels of the blocks", .low = 1, .high = 4096});
    visitor.field("layers", &Self::layers,
                  {.help = "Convolutions of each block", .low = 1, .high = 64});
    visitor.field("strides", &Self::strides,
                  {.help = "Stride of each block against the one before", .low = 1, .high = 8});
    visitor.field("up_channels", &Self::up_channels,
                  {.help = "Channels of each block brought back to the first block's resolution",
                   .low = 1,
                   .high = 4096});
  }
};

/// The boxes that the first stage starts from: one a class and heading at every cell. One entry a
/// class in each list.
struct AnchorOptions {
  std::vector<double> lengths = {3.9, 0.8, 1.76}, widths = {1.6, 0.6, 0.6},
                      heights = {1.56, 1.73, 1.73};
  /// z of their undersides, metres.
  std::vector<double> bottoms = {-1.78, -0.6, -0.6};
  /// Headings, radians; 1.57 is the published network's right angle.
  std::vector<double> rotations = {0, 1.57};
  /// Nearest bird's-eye IoU with an object from which an anchor is positive, below which negative.
  std::vector<double> positive_iou = {0.6, 0.5, 0.5}, negative_iou = {0.45, 0.35, 0.35};
  /// First and last anchors stand on the borders of the range, as in the published network, not in
  /// the middle of cells.
  bool on_borders = true;
  /// Where the two directions of the direction classifier meet, radians.
  double direction_offset = 0.78539;

  template <class Visitor>
  static void describe(Visitor& visitor) {
    using Self = AnchorOptions;
    visitor.field("lengths", &Self::lengths,
                  {.help = "Length of each class", .unit = "m", .low = 0.01, .high = 100});
    visitor.field("widths", &Self::widths,
                  {.help = "Width of each class", .unit = "m", .low = 0.01, .high = 100});
    visitor.field("heights", &Self::heights,
                  {.help = "Height of each class", .unit = "m", .low = 0.01, .high = 100});
    visitor.field("bottoms", &Self::bottoms,
                  {.help = "z of the underside of each class", .unit = "m"});
    visitor.field("rotations", &Self::rotations,
                  {.help = "Headings of every class", .unit = "rad", .low = -6.3, .high = 6.3});
    visitor.field("positive_iou", &Self::positive_iou,
                  {.help = "IoU from which an anchor is positive", .low = 0, .high = 1});
    visitor.field("negative_iou", &Self::negative_iou,
                  {.help = "IoU below which an anchor is negative", .low = 0, .high = 1});
    visitor.field("on_borders", &Self::on_borders,
                  {.help = "First and last anchors stand on the borders of the range"});
    visitor.field("direction_offset", &Self::direction_offset,
                  {.help = "Heading where the two directions meet", .unit = "rad"});
  }
};

/// Which anchors become regions of interest.
struct ProposalOptions {
  int candidates = 1024;
  double iou = 0.7;
  int count = 100;

  static ProposalOptions training() { return {.candidates = 9000, .iou = 0.8, .count = 512}; }

  template <class Visitor>
  static void describe(Visitor& visitor) {
    using Self = ProposalOptions;
    visitor.field("candidates", &Self::candidates,
                  {.help = "Anchors of the highest scores that take part", .low = 1});
    visitor.field("iou", &Self::iou,
                  {.help = "Of two that overlap more than this from above the better one stays",
                   .low = 0,
                   .high = 1});
    visitor.field("count", &Self::count, {.help = "Proposals of a scan", .low = 1});
  }
};

}  // namespace arbox::detectors::pv_rcnn
