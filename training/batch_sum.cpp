#include "arbox/training/batch_sum.h"

#include <ATen/core/grad_mode.h>
#include <ATen/ops/cat.h>
#include <ATen/ops/zeros.h>
#include <ATen/ops/zeros_like.h>

#include <cmath>
#include <cstdint>

namespace arbox::training {
namespace {

constexpr std::int64_t kMostTerms = 64;

void sum_gradients(const std::vector<at::Tensor>& parameters, at::ScalarType type,
                   Communicator& processes) {
  std::vector<at::Tensor> owners, flat;
  for (const at::Tensor& parameter : parameters) {
    if (parameter.scalar_type() != type) continue;
    const at::Tensor& gradient = parameter.grad();
    owners.push_back(parameter);
    flat.push_back(gradient.defined() ? gradient.reshape({-1})
                                      : at::zeros({parameter.numel()}, parameter.options()));
  }
  if (flat.empty()) return;
  at::Tensor all = at::cat(flat);
  processes.sum(all);
  std::int64_t begin = 0;
  for (at::Tensor& owner : owners) {
    owner.mutable_grad() = all.narrow(0, begin, owner.numel()).view(owner.sizes());
    begin += owner.numel();
  }
}

/// Equal for equal names; small enough for exact sums of squares.
double fingerprint(const std::map<std::string, double>& terms) {
  std::uint32_t hash = 2166136261U;
  for (const auto& [name, ignored] : terms) {
    for (const char letter : name + "\n")
      hash = (hash ^ static_cast<unsigned char>(letter)) * 16777619U;
  }
  return hash % 1000003U;
}

void sum_figures(BatchFigures& figures, Communicator& processes) {
  at::Tensor numbers = at::zeros({5 + kMostTerms}, at::kDouble);
  double* const values = numbers.data_ptr<double>();
  const double print = fingerprint(figures.terms);
  values[0] = figures.loss;
  values[1] = figures.stops;
  values[2] = figures.late;
  values[3] = print;
  values[4] = print * print;
  std::int64_t place = 5;
  for (const auto& [name, value] : figures.terms) {
    if (place < numbers.numel()) values[place++] = value;
  }
  processes.sum(numbers);
  figures.loss = values[0];
  figures.stops = static_cast<int>(values[1]);
  figures.late = static_cast<int>(values[2]);
  const bool same_names =
      values[3] == print * processes.size() && values[4] == print * print * processes.size();
  if (!same_names) return;
  place = 5;
  for (auto& [name, value] : figures.terms) {
    if (place < numbers.numel()) value = values[place++];
  }
}

}  // namespace

void sum_batch(const std::vector<at::Tensor>& parameters, BatchFigures& figures,
               Communicator& processes) {
  if (processes.size() == 1) return;
  sum_gradients(parameters, at::kFloat, processes);
  sum_gradients(parameters, at::kDouble, processes);
  sum_figures(figures, processes);
}

void share_from_first(const std::vector<at::Tensor>& tensors, Communicator& processes) {
  if (processes.size() == 1) return;
  const at::NoGradGuard no_gradient;
  for (const at::Tensor& tensor : tensors) {
    at::Tensor numbers = processes.rank() == 0 ? tensor.detach().clone() : at::zeros_like(tensor);
    processes.sum(numbers);
    at::Tensor(tensor).copy_(numbers);
  }
}

}  // namespace arbox::training
