#include "arbox/heads/box_head.h"

#include <ATen/ops/index_select.h>

namespace arbox::heads {

BoxCodec::~BoxCodec() = default;
BoxDistribution::~BoxDistribution() = default;
BoxHead::~BoxHead() = default;

HeadInput HeadInput::select(const at::Tensor& index) const {
  return {features.index_select(0, index), references.select(index),
          condition.defined() ? condition.index_select(0, index) : condition};
}

}  // namespace arbox::heads
