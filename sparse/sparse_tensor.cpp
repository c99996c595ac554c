#include "arbox/sparse/sparse_tensor.h"

#include <ATen/ops/empty.h>

#include <cstring>
#include <limits>
#include <sstream>
#include <utility>

#include "arbox/base/error.h"

namespace arbox::sparse {

at::Tensor to_tensor(std::span<const Coordinate> coordinates) {
  static_assert(sizeof(Coordinate) == 4 * sizeof(std::int32_t));
  at::Tensor result = at::empty({static_cast<std::int64_t>(coordinates.size()), 4}, at::kInt);
  if (!coordinates.empty()) {
    std::memcpy(result.data_ptr<std::int32_t>(), coordinates.data(), coordinates.size_bytes());
  }
  return result;
}

std::vector<Coordinate> to_coordinates(const at::Tensor& tensor) {
  if (tensor.dim() != 2 || tensor.size(1) != 4 ||
      !c10::isIntegralType(tensor.scalar_type(), false)) {
    std::ostringstream text;
    text << "sparse coordinates: expected integers (N, 4), got " << tensor.scalar_type() << " "
         << tensor.sizes();
    throw InvalidArgument(text.str());
  }
  const at::Tensor wide = tensor.to(at::kCPU, at::kLong).contiguous();
  const std::int64_t* values = wide.data_ptr<std::int64_t>();
  std::vector<Coordinate> result(wide.size(0));
  for (std::size_t i = 0; i < result.size(); ++i, values += 4) {
    for (int field = 0; field < 4; ++field) {
      if (values[field] < std::numeric_limits<std::int32_t>::min() ||
          values[field] > std::numeric_limits<std::int32_t>::max()) {
        throw InvalidArgument("sparse coordinates: row " + std::to_string(i) +
                              " holds a number beyond 32 bits");
      }
    }
    result[i] = {static_cast<std::int32_t>(values[0]), static_cast<std::int32_t>(values[1]),
                 static_cast<std::int32_t>(values[2]), static_cast<std::int32_t>(values[3])};
  }
  return result;
}

SparseTensor::SparseTensor(const at::Tensor& coordinates, at::Tensor features,
                           const Lattice& lattice, std::int64_t batch_size,
                           std::shared_ptr<CoordinateManager> manager)
    : set_(std::make_shared<const CoordinateSet>(to_coordinates(coordinates), lattice)),
      features_(std::move(features)),
      batch_size_(batch_size == 0 ? set_->batch_size() : batch_size),
      manager_(manager ? std::move(manager) : std::make_shared<CoordinateManager>()) {
  require_features();
  if (batch_size_ < set_->batch_size()) {
    throw InvalidArgument("SparseTensor: batch numbers run to " +
                          std::to_string(set_->batch_size() - 1) + ", but the batch size is " +
                          std::to_string(batch_size_));
  }
}

SparseTensor::SparseTensor(CoordinateSetPtr set, at::Tensor features, const SparseTensor& like)
    : set_(std::move(set)),
      features_(std::move(features)),
      batch_size_(like.batch_size_),
      manager_(like.manager_) {
  require_features();
}

void SparseTensor::require_features() const {
  if (features_.defined() && features_.dim() == 2 && features_.size(0) == size() &&
      features_.is_floating_point()) {
    return;
  }
  std::ostringstream text;
  text << "SparseTensor: expected floating-point features (" << size() << ", C), got ";
  if (features_.defined()) {
    text << features_.scalar_type() << " " << features_.sizes();
  } else {
    text << "an undefined tensor";
  }
  throw InvalidArgument(text.str());
}

at::Tensor SparseTensor::coordinates() const { return to_tensor(set_->in_rows()); }

at::Tensor SparseTensor::batch_numbers() const {
  at::Tensor result = at::empty({size()}, at::kLong);
  auto* numbers = result.data_ptr<std::int64_t>();
  const SortedCoordinates& sorted = set_->sorted();
  for (std::size_t i = 0; i < sorted.rows.size(); ++i) {
    numbers[sorted.rows[i]] = sorted.coordinates[i].batch;
  }
  return result.to(features_.device());
}

SparseTensor SparseTensor::with_features(at::Tensor features) const {
  return {set_, std::move(features), *this};
}

}  // namespace arbox::sparse
