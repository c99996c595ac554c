#pragma once

#include <span>

#include "arbox/sparse/sparse_tensor.h"
#include "arbox/sparse/voxelize.h"

namespace arbox::sparse {

/// One tensor of several scenes: scene i gets batch number i, whatever its voxels carry. Rows are
/// those of the scenes, one after the other. Throws InvalidArgument if the scenes' columns differ;
/// no scene at all gives (0, 3) features.
SparseTensor to_sparse_tensor(std::span<const Voxels> scenes, const Lattice& lattice = {});

}  // namespace arbox::sparse
