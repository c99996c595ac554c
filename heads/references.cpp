#include "arbox/heads/references.h"

#include <ATen/ops/index_select.h>

#include <sstream>

#include "arbox/base/error.h"

namespace arbox::heads {

References References::select(const at::Tensor& index) const {
  return {origin.index_select(0, index), rotation.index_select(0, index),
          size.index_select(0, index)};
}

References References::detached(at::ScalarType type) const {
  return {origin.detach().to(type), rotation.detach().to(type), size.detach().to(type)};
}

void References::require_valid(const char* where) const {
  const auto fits = [&](const at::Tensor& tensor, std::int64_t columns) {
    return tensor.defined() && tensor.dim() == 2 && tensor.size(1) == columns &&
           tensor.size(0) == origin.size(0);
  };
  if (fits(origin, 3) && fits(rotation, 4) && fits(size, 3)) return;
  std::ostringstream text;
  text << where << ": expected references with origin (N, 3), rotation (N, 4), size (N, 3), got";
  for (const at::Tensor* tensor : {&origin, &rotation, &size}) {
    if (tensor->defined()) {
      text << ' ' << tensor->sizes();
    } else {
      text << " undefined";
    }
  }
  throw InvalidArgument(text.str());
}

}  // namespace arbox::heads
