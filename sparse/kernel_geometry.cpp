#include "arbox/sparse/kernel_geometry.h"

#include <string>
#include <vector>

#include "arbox/base/error.h"

namespace arbox::sparse {
namespace {

constexpr std::int32_t kMost = 1024;

void require_range(const char* what, const Triple& values, std::int32_t low) {
  for (const std::int32_t value : values) {
    if (value < low || value > kMost) {
      throw InvalidArgument(std::string("sparse kernel: ") + what + " must be " +
                            std::to_string(low) + " to " + std::to_string(kMost) + ", got " +
                            std::to_string(value));
    }
  }
}

std::int32_t floor_to(std::int32_t value, std::int32_t step) {
  const std::int32_t rest = value % step;
  return value - (rest < 0 ? rest + step : rest);
}

std::vector<Triple> element_offsets(const Kernel& kernel, const Triple& scale, bool centred) {
  std::vector<Triple> offsets;
  offsets.reserve(kernel.elements());
  const auto offset = [&](std::int32_t index, int axis) {
    const bool shift = centred && kernel.size[axis] % 2 == 1;
    return (index - (shift ? (kernel.size[axis] - 1) / 2 : 0)) * kernel.dilation[axis] *
           scale[axis];
  };
  for (std::int32_t z = 0; z < kernel.size[2]; ++z) {
    for (std::int32_t y = 0; y < kernel.size[1]; ++y) {
      for (std::int32_t x = 0; x < kernel.size[0]; ++x) {
        offsets.push_back({offset(x, 0), offset(y, 1), offset(z, 2)});
      }
    }
  }
  return offsets;
}

Triple padding_of(const Kernel& kernel) {
  if (!kernel.submanifold) return kernel.padding;
  Triple padding;
  for (int axis = 0; axis < 3; ++axis)
    padding[axis] = kernel.size[axis] / 2 * kernel.dilation[axis];
  return padding;
}

/// The outputs along one axis whose receptive field holds `input`.
void reached(const Kernel& kernel, int axis, std::int32_t input, std::int32_t cells,
             std::vector<std::int32_t>& outputs) {
  outputs.clear();
  for (std::int32_t index = kernel.size[axis] - 1; index >= 0; --index) {
    const std::int32_t scaled = input + kernel.padding[axis] - index * kernel.dilation[axis];
    if (scaled < 0 || scaled % kernel.stride[axis] != 0) continue;
    const std::int32_t output = scaled / kernel.stride[axis];
    if (output < cells) outputs.push_back(output);
  }
}

SortedCoordinates grid_outputs(const Kernel& kernel, const CoordinateSet& input) {
  const Triple cells = *output_lattice(kernel, input.lattice()).grid;
  std::vector<Coordinate> all;
  all.reserve(input.size() * 4);
  std::vector<std::int32_t> xs, ys, zs;
  for (const Coordinate& c : input.sorted().coordinates) {
    reached(kernel, 0, c.x, cells[0], xs);
    reached(kernel, 1, c.y, cells[1], ys);
    reached(kernel, 2, c.z, cells[2], zs);
    for (const std::int32_t x : xs) {
      for (const std::int32_t y : ys) {
        for (const std::int32_t z : zs) all.push_back({c.batch, x, y, z});
      }
    }
  }
  return unique_coordinates(all);
}

}  // namespace

void require_kernel(const Kernel& kernel, const Lattice& lattice) {
  require_range("sizes", kernel.size, 1);
  require_range("strides", kernel.stride, 1);
  require_range("dilations", kernel.dilation, 1);
  require_range("paddings", kernel.padding, 0);
  if (!lattice.grid && (kernel.submanifold || kernel.padding != Triple{0, 0, 0})) {
    throw InvalidArgument("sparse kernel: padding and submanifold belong to grid-bounded tensors");
  }
  if (kernel.submanifold && kernel.stride != Triple{1, 1, 1}) {
    throw InvalidArgument("sparse kernel: a submanifold convolution has stride 1");
  }
}

KernelGeometry kernel_geometry(const Kernel& kernel, const Lattice& input) {
  require_kernel(kernel, input);
  if (!input.grid) return {.offsets = element_offsets(kernel, input.stride, true)};
  const Triple padding = padding_of(kernel);
  if (kernel.stride == Triple{1, 1, 1}) {
    KernelGeometry geometry{.offsets = element_offsets(kernel, {1, 1, 1}, false)};
    for (Triple& offset : geometry.offsets) {
      for (int axis = 0; axis < 3; ++axis) offset[axis] -= padding[axis];
    }
    return geometry;
  }
  return {.offsets = element_offsets(kernel, {1, 1, 1}, false),
          .scale = kernel.stride,
          .origin = {-padding[0], -padding[1], -padding[2]}};
}

Lattice output_lattice(const Kernel& kernel, const Lattice& input) {
  require_kernel(kernel, input);
  Lattice result = input;
  for (int axis = 0; axis < 3; ++axis) result.stride[axis] *= kernel.stride[axis];
  if (!input.grid || kernel.submanifold) return result;
  for (int axis = 0; axis < 3; ++axis) {
    const std::int32_t room = (*input.grid)[axis] + 2 * kernel.padding[axis] -
                              kernel.dilation[axis] * (kernel.size[axis] - 1) - 1;
    if (room < 0) {
      throw InvalidArgument("sparse kernel: a grid of " + std::to_string((*input.grid)[axis]) +
                            " cells is smaller than the kernel");
    }
    (*result.grid)[axis] = room / kernel.stride[axis] + 1;
  }
  return result;
}

SortedCoordinates output_coordinates(const Kernel& kernel, const CoordinateSet& input) {
  if (input.lattice().grid) return grid_outputs(kernel, input);
  const Triple stride = output_lattice(kernel, input.lattice()).stride;
  std::vector<Coordinate> all = input.sorted().coordinates;
  for (Coordinate& c : all) {
    c.x = floor_to(c.x, stride[0]);
    c.y = floor_to(c.y, stride[1]);
    c.z = floor_to(c.z, stride[2]);
  }
  return unique_coordinates(all);
}

Lattice generated_lattice(const Kernel& kernel, const Lattice& input) {
  require_kernel(kernel, input);
  if (input.grid) {
    throw InvalidArgument("generative convolution: grid-bounded tensors are not supported");
  }
  Lattice result = input;
  for (int axis = 0; axis < 3; ++axis) {
    if (input.stride[axis] % kernel.stride[axis] != 0) {
      throw InvalidArgument(
          "generative convolution: the kernel's stride " + std::to_string(kernel.stride[axis]) +
          " does not divide the tensor's stride " + std::to_string(input.stride[axis]));
    }
    result.stride[axis] /= kernel.stride[axis];
  }
  return result;
}

SortedCoordinates generated_coordinates(const Kernel& kernel, const CoordinateSet& input) {
  const Lattice lattice = generated_lattice(kernel, input.lattice());
  const std::vector<Triple> offsets = element_offsets(kernel, lattice.stride, true);
  std::vector<Coordinate> all;
  all.reserve(input.size() * offsets.size());
  for (const Coordinate& c : input.sorted().coordinates) {
    for (const Triple& o : offsets) all.push_back({c.batch, c.x + o[0], c.y + o[1], c.z + o[2]});
  }
  return unique_coordinates(all);
}

}  // namespace arbox::sparse
