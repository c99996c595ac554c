#pragma once

#include <ATen/core/Tensor.h>

#include <algorithm>
#include <cstdint>
#include <vector>

namespace arbox::training {

/// Elements [begin, end) of tensor number `tensor` of a list.
struct TensorChunk {
  std::size_t tensor = 0;
  std::int64_t begin = 0;
  std::int64_t end = 0;
};

constexpr std::int64_t kChunkElements = 1 << 14;

/// Cuts tensors into chunks of at most kChunkElements, in order.
inline std::vector<TensorChunk> cut_tensors(const std::vector<at::Tensor>& tensors) {
  std::vector<TensorChunk> chunks;
  for (std::size_t tensor = 0; tensor < tensors.size(); ++tensor) {
    const std::int64_t count = tensors[tensor].numel();
    for (std::int64_t begin = 0; begin < count; begin += kChunkElements) {
      chunks.push_back({tensor, begin, std::min(count, begin + kChunkElements)});
    }
  }
  return chunks;
}

/// Where a chunk begins in memory; Number is the tensor's type.
template <class Number>
Number* numbers_of(const at::Tensor& tensor, const TensorChunk& chunk) {
  return static_cast<Number*>(tensor.data_ptr()) + chunk.begin;
}

/// Calls body(0.0F) for a float32 tensor, body(0.0) for a float64 one.
template <class Body>
void for_number_type(const at::Tensor& tensor, const Body& body) {
  if (tensor.scalar_type() == at::kFloat) {
    body(float{});
  } else {
    body(double{});
  }
}

}  // namespace arbox::training
