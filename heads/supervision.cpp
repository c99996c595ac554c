#include "arbox/heads/supervision.h"

#include <ATen/ops/ones.h>

#include "arbox/heads/internal/component_math.h"

namespace arbox::heads {

ComponentSet supervised_vectors(const BoxCodec& codec, const at::Tensor& boxes,
                                const References& references, Supervision supervision) {
  const References fixed = references.detached(boxes.scalar_type());
  if (supervision != Supervision::kCanonical) return codec.equivalents(boxes, fixed);
  return {codec.encode(boxes, fixed).unsqueeze(1), at::ones({boxes.size(0), 1}, at::kBool)};
}

at::Tensor reduce_vectors(const at::Tensor& losses, const at::Tensor& mask,
                          Supervision supervision) {
  return supervision == Supervision::kNearest ? internal::masked_least(losses, mask)
                                              : internal::masked_mean(losses, mask);
}

}  // namespace arbox::heads
