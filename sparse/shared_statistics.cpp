#include "arbox/sparse/shared_statistics.h"

#include <ATen/TensorOperators.h>
#include <ATen/core/ivalue.h>
#include <ATen/ops/cat.h>
#include <ATen/ops/full.h>
#include <torch/csrc/autograd/custom_function.h>

#include <utility>

namespace arbox::sparse {
namespace {

using torch::autograd::AutogradContext;
using torch::autograd::variable_list;
using SharedSum = std::shared_ptr<const SharedStatistics::Sum>;

thread_local SharedSum innermost;

struct SumHolder : torch::CustomClassHolder {
  explicit SumHolder(SharedSum held) : sum(std::move(held)) {}
  SharedSum sum;
};

at::Tensor column_sums(const at::Tensor& values) { return values.sum({0}, false, at::kDouble); }

class SharedBatchNorm : public torch::autograd::Function<SharedBatchNorm> {
 public:
  static at::Tensor forward(AutogradContext* context, const at::Tensor& rows,
                            const at::Tensor& weight, const at::Tensor& bias,
                            const NormStatistics& statistics, double epsilon,
                            const SharedSum& sum) {
    const at::Tensor inverse = (statistics.variance + epsilon).rsqrt().to(rows.scalar_type());
    const at::Tensor normal = (rows - statistics.mean.to(rows.scalar_type())) * inverse;
    context->save_for_backward({normal, inverse, weight});
    context->saved_data["count"] = statistics.count;
    context->saved_data["sum"] = c10::IValue::make_capsule(c10::make_intrusive<SumHolder>(sum));
    return normal * weight + bias;
  }

  static variable_list backward(AutogradContext* context, variable_list gradients) {
    const variable_list saved = context->get_saved_variables();
    const at::Tensor &normal = saved[0], &inverse = saved[1], &weight = saved[2];
    const at::Tensor& gradient = gradients[0];
    const auto type = normal.scalar_type();
    const at::Tensor to_bias = column_sums(gradient);
    const at::Tensor to_weight = column_sums(gradient * normal);
    at::Tensor means = at::cat({to_bias, to_weight});
    const c10::IValue& holder = context->saved_data["sum"];
    (*static_cast<const SumHolder&>(*holder.toCapsule()).sum)(means);
    means = (means / context->saved_data["count"].toDouble()).to(type);
    const std::int64_t channels = to_bias.size(0);
    const at::Tensor to_rows =
        (gradient - means.narrow(0, 0, channels) - normal * means.narrow(0, channels, channels)) *
        (inverse * weight);
    return {to_rows,      to_weight.to(type), to_bias.to(type),
            at::Tensor(), at::Tensor(),       at::Tensor()};
  }
};

}  // namespace

SharedStatistics::SharedStatistics(Sum sum)
    : outer_(std::exchange(innermost, std::make_shared<const Sum>(std::move(sum)))) {}

SharedStatistics::~SharedStatistics() { innermost = std::move(outer_); }

std::shared_ptr<const SharedStatistics::Sum> SharedStatistics::current() { return innermost; }

NormStatistics shared_statistics(const at::Tensor& rows, const SharedStatistics::Sum& sum) {
  const at::Tensor x = rows.detach();
  const std::int64_t channels = x.size(1);
  const auto count = static_cast<double>(x.size(0));
  const at::Tensor mean = column_sums(x) / std::max(count, 1.0);
  // Squares about this process's own mean: their sum does not cancel.
  const at::Tensor spread = column_sums((x - mean.to(x.scalar_type())).square());
  at::Tensor all =
      at::cat({mean * count, spread + mean.square() * count, at::full({1}, count, mean.options())});
  sum(all);
  const double total = all[2 * channels].item<double>();
  const at::Tensor moments = all.narrow(0, 0, 2 * channels) / std::max(total, 1.0);
  const at::Tensor common = moments.narrow(0, 0, channels);
  return {common, (moments.narrow(0, channels, channels) - common.square()).clamp_min(0), total};
}

at::Tensor shared_batch_norm(const at::Tensor& rows, const at::Tensor& weight,
                             const at::Tensor& bias, const NormStatistics& statistics,
                             double epsilon, std::shared_ptr<const SharedStatistics::Sum> sum) {
  return SharedBatchNorm::apply(rows, weight, bias, statistics, epsilon, sum);
}

}  // namespace arbox::sparse
