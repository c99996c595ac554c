#include "arbox/sparse/coordinate_manager.h"

#include <utility>

#include "arbox/base/error.h"

namespace arbox::sparse {
namespace {

KernelMap turned(KernelMap map) {
  std::swap(map.inputs, map.outputs);
  return map;
}

std::shared_ptr<const KernelMap> shared(KernelMap map) {
  return std::make_shared<const KernelMap>(std::move(map));
}

}  // namespace

const Connection* CoordinateManager::find(Kind kind, const Kernel& kernel,
                                          const CoordinateSetPtr& source,
                                          const CoordinateSetPtr& target) const {
  for (const Entry& entry : entries_) {
    if (entry.kind == kind && entry.source == source && entry.target == target &&
        entry.kernel == kernel) {
      return &entry.connection;
    }
  }
  return nullptr;
}

Connection CoordinateManager::keep(Entry entry) {
  entries_.push_back(std::move(entry));
  return entries_.back().connection;
}

CoordinateSetPtr CoordinateManager::outputs_of(const CoordinateSetPtr& set, const Kernel& kernel) {
  const Lattice lattice = output_lattice(kernel, set->lattice());
  const bool unbounded = !set->lattice().grid;
  if (kernel.submanifold || (unbounded && kernel.stride == Triple{1, 1, 1})) return set;
  if (unbounded) {
    for (const Strided& known : strided_) {
      if (known.source == set && known.stride == kernel.stride) return known.outputs;
    }
  }
  auto outputs = std::make_shared<const CoordinateSet>(output_coordinates(kernel, *set), lattice);
  if (unbounded) strided_.push_back({set, kernel.stride, outputs});
  return outputs;
}

Connection CoordinateManager::convolution(const CoordinateSetPtr& set, const Kernel& kernel) {
  const std::scoped_lock lock(mutex_);
  if (const auto* known = find(Kind::kForward, kernel, set, nullptr)) return *known;
  const CoordinateSetPtr outputs = outputs_of(set, kernel);
  const KernelGeometry geometry = kernel_geometry(kernel, set->lattice());
  auto map = shared(build_kernel_map(set->sorted(), outputs->sorted(), geometry, threads_));
  return keep({Kind::kForward, kernel, set, nullptr, {set, outputs, std::move(map)}});
}

Connection CoordinateManager::transposed(const CoordinateSetPtr& set,
                                         const CoordinateSetPtr& target, const Kernel& kernel) {
  const std::scoped_lock lock(mutex_);
  if (const auto* known = find(Kind::kTransposed, kernel, set, target)) return *known;
  if (output_lattice(kernel, target->lattice()) != set->lattice()) {
    throw InvalidArgument(
        "transposed convolution: the target's stride times the kernel's is not the tensor's (or "
        "the grids differ)");
  }
  const auto* forward = find(Kind::kForward, kernel, target, nullptr);
  auto map =
      forward != nullptr && forward->outputs == set
          ? shared(turned(*forward->map))
          : shared(turned(build_kernel_map(target->sorted(), set->sorted(),
                                           kernel_geometry(kernel, target->lattice()), threads_)));
  return keep({Kind::kTransposed, kernel, set, target, {set, target, std::move(map)}});
}

Connection CoordinateManager::generative(const CoordinateSetPtr& set, const Kernel& kernel) {
  const std::scoped_lock lock(mutex_);
  if (const auto* known = find(Kind::kGenerative, kernel, set, nullptr)) return *known;
  const Lattice lattice = generated_lattice(kernel, set->lattice());
  auto children =
      std::make_shared<const CoordinateSet>(generated_coordinates(kernel, *set), lattice);
  auto map = shared(turned(build_kernel_map(children->sorted(), set->sorted(),
                                            kernel_geometry(kernel, lattice), threads_)));
  return keep({Kind::kGenerative, kernel, set, nullptr, {set, children, std::move(map)}});
}

Connection CoordinateManager::pointwise(const CoordinateSetPtr& set) {
  const bool grid = set->lattice().grid.has_value();
  return convolution(set, {.size = {1, 1, 1}, .submanifold = grid});
}

void CoordinateManager::clear() {
  const std::scoped_lock lock(mutex_);
  entries_.clear();
  strided_.clear();
}

std::size_t CoordinateManager::maps() const {
  const std::scoped_lock lock(mutex_);
  return entries_.size();
}

}  // namespace arbox::sparse
