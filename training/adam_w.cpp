#include "arbox/training/adam_w.h"

#include <ATen/ops/zeros_like.h>

#include <cmath>
#include <numeric>
#include <string>
#include <utility>

#include "arbox/base/error.h"
#include "arbox/base/parallel.h"

namespace arbox::training {
namespace {

constexpr std::int64_t kChunksAtOnce = 4;

struct StepFactors {
  double keep, momentum, beta2, rate, root, epsilon, scale;
};

template <class Number>
void step_chunk(Number* value, Number* first, Number* second, const Number* gradient,
                std::int64_t count, const StepFactors& factors) {
  const auto keep = static_cast<Number>(factors.keep);
  const auto momentum = static_cast<Number>(factors.momentum);
  const auto beta2 = static_cast<Number>(factors.beta2);
  const auto new1 = static_cast<Number>(1 - factors.momentum);
  const auto new2 = static_cast<Number>(1 - factors.beta2);
  const auto rate = static_cast<Number>(factors.rate);
  const auto root = static_cast<Number>(factors.root);
  const auto epsilon = static_cast<Number>(factors.epsilon);
  const auto scale = static_cast<Number>(factors.scale);
#pragma omp simd
  for (std::int64_t i = 0; i < count; ++i) {
    const Number g = gradient[i] * scale;
    const Number m = momentum * first[i] + new1 * g;
    const Number v = beta2 * second[i] + new2 * g * g;
    first[i] = m;
    second[i] = v;
    value[i] = value[i] * keep - rate * m / (std::sqrt(v) * root + epsilon);
  }
}

template <class Number>
double squares(const Number* values, std::int64_t count) {
  double sum = 0;
#pragma omp simd reduction(+ : sum)
  for (std::int64_t i = 0; i < count; ++i) {
    sum += static_cast<double>(values[i]) * static_cast<double>(values[i]);
  }
  return sum;
}

}  // namespace

AdamW::AdamW(std::vector<at::Tensor> parameters, const AdamWOptions& options)
    : parameters_(std::move(parameters)), options_(options) {
  for (std::size_t i = 0; i < parameters_.size(); ++i) {
    const at::Tensor& parameter = parameters_[i];
    const bool number =
        parameter.scalar_type() == at::kFloat || parameter.scalar_type() == at::kDouble;
    if (!number || !parameter.is_contiguous() || !parameter.device().is_cpu()) {
      throw InvalidArgument("AdamW: parameter " + std::to_string(i) +
                            " is not a contiguous float32 or float64 CPU tensor");
    }
    first_.push_back(at::zeros_like(parameter.detach()));
    second_.push_back(at::zeros_like(parameter.detach()));
  }
  chunks_ = cut_tensors(parameters_);
}

std::vector<at::Tensor> AdamW::gradients() const {
  std::vector<at::Tensor> gradients;
  gradients.reserve(parameters_.size());
  for (const at::Tensor& parameter : parameters_) {
    const at::Tensor& gradient = parameter.grad();
    gradients.push_back(gradient.defined() ? gradient.contiguous() : gradient);
  }
  return gradients;
}

double AdamW::gradient_norm() const {
  const std::vector<at::Tensor> all = gradients();
  std::vector<double> sums(chunks_.size(), 0.0);
  parallel_for(
      static_cast<std::int64_t>(chunks_.size()), kChunksAtOnce, 0, [&](auto begin, auto end) {
        for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i) {
          const TensorChunk& chunk = chunks_[i];
          const at::Tensor& gradient = all[chunk.tensor];
          if (!gradient.defined()) continue;
          for_number_type(gradient, [&](auto type) {
            sums[i] = squares(numbers_of<decltype(type)>(gradient, chunk), chunk.end - chunk.begin);
          });
        }
      });
  return std::sqrt(std::accumulate(sums.begin(), sums.end(), 0.0));
}

void AdamW::step(const CyclePoint& point, double gradient_scale) {
  ++steps_;
  const auto steps = static_cast<double>(steps_);
  const StepFactors factors{
      .keep = 1 - point.learning_rate * options_.weight_decay,
      .momentum = point.momentum,
      .beta2 = options_.beta2,
      .rate = point.learning_rate / (1 - std::pow(point.momentum, steps)),
      .root = 1 / std::sqrt(1 - std::pow(options_.beta2, steps)),
      .epsilon = options_.epsilon,
      .scale = gradient_scale,
  };
  const std::vector<at::Tensor> all = gradients();
  parallel_for(
      static_cast<std::int64_t>(chunks_.size()), kChunksAtOnce, 0, [&](auto begin, auto end) {
        for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i) {
          const TensorChunk& chunk = chunks_[i];
          const at::Tensor& gradient = all[chunk.tensor];
          for_number_type(parameters_[chunk.tensor], [&](auto type) {
            using Number = decltype(type);
            static const std::vector<Number> zeros(kChunkElements);
            step_chunk(numbers_of<Number>(parameters_[chunk.tensor], chunk),
                       numbers_of<Number>(first_[chunk.tensor], chunk),
                       numbers_of<Number>(second_[chunk.tensor], chunk),
                       gradient.defined() ? numbers_of<Number>(gradient, chunk) : zeros.data(),
                       chunk.end - chunk.begin, factors);
          });
        }
      });
}

void AdamW::clear_gradients() {
  for (at::Tensor& parameter : parameters_) parameter.mutable_grad() = at::Tensor();
}

}  // namespace arbox::training
