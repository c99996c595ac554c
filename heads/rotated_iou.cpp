#include "arbox/heads/rotated_iou.h"

#include <ATen/TensorOperators.h>
#include <ATen/core/ivalue.h>  // before autograd headers: clang cannot parse them otherwise
#include <ATen/ops/cat.h>
#include <ATen/ops/empty.h>
#include <ATen/ops/empty_like.h>
#include <torch/csrc/autograd/custom_function.h>

#include <algorithm>
#include <sstream>

#include "arbox/base/error.h"
#include "arbox/base/parallel.h"
#include "arbox/heads/box_tensor.h"
#include "arbox/heads/internal/rotation_tensor.h"
#include "arbox/heads/internal/upright_overlap.h"

namespace arbox::heads {
namespace {

using at::Tensor;

constexpr std::int64_t kColumns = 7;

class RotatedIou : public torch::autograd::Function<RotatedIou> {
 public:
  static Tensor forward(torch::autograd::AutogradContext* context, const Tensor& first,
                        const Tensor& second) {
    const Tensor a = first.to(at::kDouble).contiguous(), b = second.to(at::kDouble).contiguous();
    const std::int64_t pairs = a.numel() / kColumns;
    Tensor iou = at::empty({pairs}, at::kDouble);
    Tensor of_a = at::empty({pairs, kColumns}, at::kDouble), of_b = at::empty_like(of_a);
    const auto* from_a = reinterpret_cast<const internal::UprightBox*>(a.data_ptr<double>());
    const auto* from_b = reinterpret_cast<const internal::UprightBox*>(b.data_ptr<double>());
    parallel_for(pairs, 64, 0, [&](std::int64_t begin, std::int64_t end) {
      for (std::int64_t i = begin; i < end; ++i) {
        const internal::UprightIou pair = internal::upright_iou(from_a[i], from_b[i]);
        iou.data_ptr<double>()[i] = pair.iou;
        std::copy_n(pair.first_gradient.data(), kColumns, of_a.data_ptr<double>() + i * kColumns);
        std::copy_n(pair.second_gradient.data(), kColumns, of_b.data_ptr<double>() + i * kColumns);
      }
    });
    context->save_for_backward({of_a.view(first.sizes()), of_b.view(second.sizes())});
    context->saved_data["first"] = static_cast<std::int64_t>(first.scalar_type());
    context->saved_data["second"] = static_cast<std::int64_t>(second.scalar_type());
    return iou.view(first.sizes().slice(0, first.dim() - 1)).to(first.scalar_type());
  }

  static torch::autograd::variable_list backward(torch::autograd::AutogradContext* context,
                                                 torch::autograd::variable_list gradients) {
    const auto saved = context->get_saved_variables();
    const Tensor outer = gradients[0].to(at::kDouble).unsqueeze(-1);
    const auto type = [&](const char* name) {
      return static_cast<at::ScalarType>(context->saved_data[name].toInt());
    };
    return {(outer * saved[0]).to(type("first")), (outer * saved[1]).to(type("second"))};
  }
};

}  // namespace

Tensor rotated_iou(const Tensor& first, const Tensor& second) {
  if (first.dim() < 1 || first.size(-1) != kColumns || first.sizes() != second.sizes()) {
    std::ostringstream text;
    text << "rotated_iou: expected two tensors of one shape (..., 7), got " << first.sizes()
         << " and " << second.sizes();
    throw InvalidArgument(text.str());
  }
  return RotatedIou::apply(first, second);
}

Tensor upright_boxes(const Tensor& boxes) {
  require_boxes(boxes, "upright_boxes");
  return at::cat({boxes.slice(-1, 0, 6), internal::yaw_of(boxes.slice(-1, 6, 10)).unsqueeze(-1)},
                 -1);
}

}  // namespace arbox::heads
