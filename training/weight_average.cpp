#include "arbox/training/weight_average.h"

#include <ATen/core/grad_mode.h>

#include <algorithm>
#include <utility>

#include "arbox/base/parallel.h"

namespace arbox::training {
namespace {

template <class Number>
void approach(Number* average, const Number* weight, std::int64_t count, double step) {
  const auto part = static_cast<Number>(step);
  for (std::int64_t i = 0; i < count; ++i) average[i] += part * (weight[i] - average[i]);
}

}  // namespace

WeightAverage::WeightAverage(std::vector<at::Tensor> weights, double decay)
    : weights_(std::move(weights)), chunks_(cut_tensors(weights_)), decay_(decay) {
  for (const at::Tensor& weight : weights_) average_.push_back(weight.detach().clone());
}

void WeightAverage::update(std::int64_t step) {
  const auto number = static_cast<double>(step);
  const double part = 1 - std::min(decay_, (1 + number) / (10 + number));
  parallel_for(static_cast<std::int64_t>(chunks_.size()), 4, 0, [&](auto begin, auto end) {
    for (std::int64_t i = begin; i < end; ++i) {
      const TensorChunk& chunk = chunks_[static_cast<std::size_t>(i)];
      for_number_type(weights_[chunk.tensor], [&](auto number_type) {
        using Number = decltype(number_type);
        approach(numbers_of<Number>(average_[chunk.tensor], chunk),
                 numbers_of<Number>(weights_[chunk.tensor], chunk), chunk.end - chunk.begin, part);
      });
    }
  });
}

void WeightAverage::swap() {
  const at::NoGradGuard no_gradient;
  for (std::size_t i = 0; i < weights_.size(); ++i) {
    const at::Tensor weight = weights_[i].detach().clone();
    weights_[i].copy_(average_[i]);
    average_[i].copy_(weight);
  }
}

}  // namespace arbox::training
