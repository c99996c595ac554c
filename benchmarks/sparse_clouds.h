#pragma once

#include <cstdint>
#include <vector>

#include "arbox/sparse/coordinate_set.h"

namespace arbox::benchmarks {

/// A made room of 6 x 6 x 2.6 m with floor, walls and 25 boxes turned about z, as voxels of 2 cm:
/// the `count` voxels nearest to a corner of the floor, in random row order. The same for the same
/// count.
std::vector<sparse::Coordinate> room_voxels(std::size_t count);

/// KITTI frames 000000, 000001, ... below ARBOX_DATA as voxels of 0.05 x 0.05 x 0.1 m, one frame a
/// batch item, the `count` voxels nearest to the scanner, in random row order. Empty without data.
std::vector<sparse::Coordinate> kitti_voxels(std::size_t count);

/// x y z of the points of the KITTI frame `number` in front of the scanner (45 degrees to each
/// side); a made ring of points without data.
std::vector<float> kitti_points(int number, std::size_t count);

/// Voxels of 1 cm of ScanNet's scene0000_00 below ARBOX_DATA; empty without data.
std::vector<sparse::Coordinate> scannet_voxels();

}  // namespace arbox::benchmarks
