#pragma once

#include <span>

#include "arbox/sparse/coordinate_set.h"
#include "arbox/sparse/kernel_map.h"

/// \file
/// What a kernel of a convolution means on a lattice: which voxels it reads and which it writes.
///
/// Elements of a kernel are numbered with x fastest: k = ix + size[0] * (iy + size[1] * iz). That
/// is the order of MinkowskiEngine's `kernel` rows, and of spconv's (kz, ky, kx) axes laid flat.

namespace arbox::sparse {

/// The shape of a sparse convolution or pooling.
struct Kernel {
  Triple size{3, 3, 3};
  Triple stride{1, 1, 1};
  Triple dilation{1, 1, 1};
  /// Grid-bounded tensors only, and only where not submanifold.
  Triple padding{0, 0, 0};
  /// Grid-bounded tensors only: outputs are the inputs' voxels and the kernel is centred. Unbounded
  /// tensors of stride 1 are always so.
  bool submanifold = false;

  std::int64_t elements() const { return std::int64_t{size[0]} * size[1] * size[2]; }
  friend auto operator<=>(const Kernel&, const Kernel&) = default;
};

/// Throws InvalidArgument unless sizes, strides and dilations are 1 to 1024, padding is not
/// negative, a submanifold kernel has stride 1, and padding or submanifold are not asked of an
/// unbounded lattice.
void require_kernel(const Kernel& kernel, const Lattice& lattice);

/// Which input voxel each element reads.
///
/// Unbounded: input = output + offset * input stride * dilation, with offset = index - (size - 1) /
/// 2 for odd sizes and offset = index for even ones (not centred). Grid: input = output * stride -
/// padding + index * dilation; a submanifold kernel uses padding (size / 2) * dilation.
KernelGeometry kernel_geometry(const Kernel& kernel, const Lattice& input);

/// The lattice of the outputs. Grids: floor((grid + 2 padding - dilation (size - 1) - 1) / stride)
/// + 1 cells an axis; throws InvalidArgument if none is left.
Lattice output_lattice(const Kernel& kernel, const Lattice& input);

/// The voxels that a strided convolution writes, sorted.
///
/// Unbounded: floor(c / (stride * input stride)) * (stride * input stride) for each input c. Grid:
/// every cell whose receptive field holds an input.
SortedCoordinates output_coordinates(const Kernel& kernel, const CoordinateSet& input);

/// The lattice of a generative transposed convolution: input stride / kernel stride. Throws
/// InvalidArgument for grids and for strides that do not divide.
Lattice generated_lattice(const Kernel& kernel, const Lattice& input);

/// All children of a generative transposed convolution, sorted: c + offset * output stride for
/// each input c and each kernel element.
SortedCoordinates generated_coordinates(const Kernel& kernel, const CoordinateSet& input);

}  // namespace arbox::sparse
