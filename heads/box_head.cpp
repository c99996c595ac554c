#include "arbox/heads/box_head.h"

#include <ATen/TensorOperators.h>
#include <ATen/ops/arange.h>
#include <ATen/ops/cat.h>
#include <ATen/ops/isfinite.h>

#include <sstream>

#include "arbox/base/error.h"
#include "arbox/heads/box_tensor.h"

namespace arbox::heads {
namespace {

void require_shape(const at::Tensor& tensor, std::int64_t rows, std::int64_t columns,
                   const char* where, const char* name) {
  if (tensor.defined() && tensor.dim() == 2 && tensor.size(0) == rows &&
      tensor.size(1) == columns) {
    return;
  }
  std::ostringstream text;
  text << where << ": expected " << name << " of shape (" << rows << ", " << columns << "), got ";
  if (tensor.defined()) {
    text << tensor.sizes();
  } else {
    text << "none";
  }
  throw InvalidArgument(text.str());
}

void require_finite(const at::Tensor& tensor, const char* where, const char* name) {
  const at::Tensor bad = at::isfinite(tensor.detach()).logical_not().any(-1);
  if (!bad.any().item<bool>()) return;
  throw NumericalError(std::string(where) + ": the tensor '" + name +
                       "' holds a non-finite number in row " +
                       std::to_string(bad.nonzero()[0][0].item<std::int64_t>()));
}

}  // namespace

BoxHead::~BoxHead() = default;

HeadInput HeadInput::select(const at::Tensor& index) const {
  return {features.index_select(0, index), references.select(index),
          condition.defined() ? condition.index_select(0, index) : condition, seed,
          streams().object_ids.index_select(0, index)};
}

Streams HeadInput::streams() const {
  return {seed, object_ids.defined() ? object_ids : at::arange(count(), at::kLong)};
}

at::Tensor HeadInput::joined() const {
  return condition.defined() ? at::cat({features, condition}, 1) : features;
}

void HeadInput::require_valid(const HeadContext& context, const char* where) const {
  require_shape(features, count(), context.features, where, "features");
  if (condition.defined() || context.condition > 0) {
    require_shape(condition, count(), context.condition, where, "condition");
    require_finite(condition, where, "condition");
  }
  references.require_valid(where);
  require_shape(references.origin, count(), 3, where, "references.origin");
  require_finite(features, where, "features");
  require_finite(references.origin, where, "references.origin");
  require_finite(references.rotation, where, "references.rotation");
  require_finite(references.size, where, "references.size");
}

void require_targets(const at::Tensor& boxes, std::int64_t count, const char* where) {
  require_shape(boxes, count, kBoxColumns, where, "target boxes");
  require_finite(boxes, where, "target boxes");
  const at::Tensor bad = (boxes.detach().slice(1, 3, 6) <= 0).any(-1);
  if (!bad.any().item<bool>()) return;
  throw NumericalError(std::string(where) + ": target box " +
                       std::to_string(bad.nonzero()[0][0].item<std::int64_t>()) +
                       " has a size that is not above zero");
}

}  // namespace arbox::heads
