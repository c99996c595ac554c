#pragma once

#include <span>

#include "arbox/sparse/kernel_map.h"

namespace arbox::benchmarks {

/// build_kernel_map of one coordinate set and a 3 x 3 x 3 kernel by a hash table (open addressing,
/// linear probing, 64-bit keys, at most half full), as spconv and MinkowskiEngine find their pairs:
/// what merging sorted lists is compared with. Needs no sorted coordinates, but the order of rows
/// in which the convolution would gather is the caller's. threads = 0 means default_threads().
sparse::KernelMap hashed_kernel_map(std::span<const sparse::Coordinate> coordinates,
                                    int threads = 0);

}  // namespace arbox::benchmarks
