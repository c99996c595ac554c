#pragma once

#include "arbox/sparse/sparse_tensor.h"

/// \file
/// Tensors narrowed, joined and read at places. All are differentiable in the features and work on
/// the features' device.

namespace arbox::sparse {

/// The voxels whose entry of `keep` (N) bool is true, in their order.
/// Throws InvalidArgument for another shape or type.
SparseTensor prune(const SparseTensor& tensor, const at::Tensor& keep);

/// (N) bool: the `count` highest scores (N) of each scene (FCAF3D's pruning). Ties go to the
/// earlier row; NaN is lowest. O(N). Throws InvalidArgument for another shape or count < 0.
at::Tensor highest_in_each_scene(const SparseTensor& tensor, const at::Tensor& scores,
                                 std::int64_t count);

/// Sum over the union of the voxels; where one tensor has no voxel it counts as 0. Rows of the
/// result are in sorted order, or the operands' own if they share one set. Throws InvalidArgument
/// if lattices or channels differ.
SparseTensor add(const SparseTensor& a, const SparseTensor& b);

/// Features at places (M, 4): batch, x, y, z in voxel units of the coordinates, integer or
/// floating-point. Trilinear between the voxels at multiples of the stride around it; absent ones
/// count as 0 and the weights are not renormalised (MinkowskiEngine's features_at_coordinates).
/// (M, C). Grid-bounded tensors have stride 1 here.
at::Tensor interpolate(const SparseTensor& tensor, const at::Tensor& places);

/// A box of voxels: multiples of the stride from `low`, `cells` of them along x, y, z.
struct DenseRegion {
  Triple low{0, 0, 0};
  Triple cells{1, 1, 1};
};

/// (B, C, Z, Y, X): absent voxels 0, memory in the order B, Z, Y, X, C. Voxels outside of the
/// region are left out. Without a region the tensor must be grid-bounded; throws InvalidArgument
/// otherwise.
at::Tensor to_dense(const SparseTensor& tensor);
at::Tensor to_dense(const SparseTensor& tensor, const DenseRegion& region);

/// The voxels of dense (B, C, Z, Y, X) where `occupied` (B, Z, Y, X) bool is true, or where any
/// channel is not 0 if it is undefined. Coordinates are low + index * lattice.stride, or the index
/// for grids. Rows in the order of B, Z, Y, X.
SparseTensor from_dense(const at::Tensor& dense, const Lattice& lattice = {},
                        const Triple& low = {0, 0, 0}, const at::Tensor& occupied = {});

/// Grid-bounded tensors seen from above: (B, C * Z, Y, X) with channel c * Z + z.
at::Tensor birds_eye(const SparseTensor& tensor);

}  // namespace arbox::sparse
