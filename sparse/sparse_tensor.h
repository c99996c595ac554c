#pragma once

#include <ATen/core/Tensor.h>

#include <memory>

#include "arbox/sparse/coordinate_manager.h"

namespace arbox::sparse {

/// Features of the occupied voxels of a batch of scenes. A value type; copies share everything.
///
/// Row i of features() (N, C) belongs to row i of coordinates() (N, 4): batch, x, y, z. Features
/// are float32, or float64 for gradient checks, on any device; the coordinate set lives on the CPU.
/// Tensors of one network pass share one CoordinateManager, so that kernel maps are built once.
/// What coordinates and strides mean: Lattice, docs/sparse.md.
class SparseTensor {
 public:
  /// coordinates (N, 4) of an integer type, distinct; features (N, C) floating point.
  /// batch_size 0 means one more than the largest batch number; scenes without voxels at the end
  /// of a batch need it said. Throws InvalidArgument for other shapes and types, a batch number
  /// beyond batch_size, and as CoordinateSet does. N = 0 is fine.
  SparseTensor(const at::Tensor& coordinates, at::Tensor features, const Lattice& lattice = {},
               std::int64_t batch_size = 0, std::shared_ptr<CoordinateManager> manager = nullptr);
  /// On a set that exists; `like` gives manager and batch size.
  SparseTensor(CoordinateSetPtr set, at::Tensor features, const SparseTensor& like);

  const at::Tensor& features() const { return features_; }
  /// (N, 4) int32 on the CPU, built anew at each call: O(N).
  at::Tensor coordinates() const;
  /// (N) int64 on the features' device: the scene of each row. O(N).
  at::Tensor batch_numbers() const;

  std::int64_t size() const { return set_->size(); }
  std::int64_t channels() const { return features_.size(1); }
  std::int64_t batch_size() const { return batch_size_; }
  const Lattice& lattice() const { return set_->lattice(); }
  const CoordinateSetPtr& set() const { return set_; }
  CoordinateManager& manager() const { return *manager_; }

  /// The same voxels with other features (N, C').
  SparseTensor with_features(at::Tensor features) const;

 private:
  void require_features() const;

  CoordinateSetPtr set_;
  at::Tensor features_;
  std::int64_t batch_size_ = 0;
  std::shared_ptr<CoordinateManager> manager_;
};

/// (N, 4) int32 on the CPU of coordinates.
at::Tensor to_tensor(std::span<const Coordinate> coordinates);
/// Coordinates of an integer tensor (N, 4); throws InvalidArgument for other shapes or types, and
/// for values beyond int32.
std::vector<Coordinate> to_coordinates(const at::Tensor& tensor);

}  // namespace arbox::sparse
