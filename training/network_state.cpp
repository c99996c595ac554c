#include "arbox/training/network_state.h"

#include <ATen/core/grad_mode.h>
#include <ATen/core/ivalue.h>
// ivalue.h must come before the module header (clang).
#include <torch/nn/module.h>

#include <algorithm>
#include <sstream>

#include "arbox/base/error.h"
#include "arbox/base/names.h"

namespace arbox::training {
namespace {

bool in_any(const std::string& name, const std::vector<std::string>& parts) {
  return std::any_of(parts.begin(), parts.end(),
                     [&](const std::string& part) { return in_part(name, part); });
}

void require_parts(const torch::nn::Module& network, const std::vector<std::string>& parts) {
  std::vector<std::string> known;
  for (const auto& module : network.named_modules()) {
    if (!module.key().empty()) known.push_back(module.key());
  }
  for (const auto& parameter : network.named_parameters()) known.push_back(parameter.key());
  for (const std::string& part : parts) {
    if (std::find(known.begin(), known.end(), part) != known.end()) continue;
    const std::string nearest = nearest_name(part, known);
    throw ConfigError("frozen: the network has no part '" + part + "'" +
                      (nearest.empty() ? "" : ", nearest is '" + nearest + "'"));
  }
}

std::string difference(const at::Tensor& expected, const at::Tensor& got) {
  std::ostringstream text;
  text << "expected " << expected.scalar_type() << ' ' << expected.sizes() << ", got "
       << got.scalar_type() << ' ' << got.sizes();
  return text.str();
}

}  // namespace

bool in_part(const std::string& name, const std::string& part) {
  return name.starts_with(part) && (name.size() == part.size() || name[part.size()] == '.');
}

void set_training(torch::nn::Module& network, const std::vector<std::string>& frozen) {
  require_parts(network, frozen);
  network.train();
  for (auto& module : network.named_modules()) {
    if (in_any(module.key(), frozen)) module.value()->eval();
  }
  for (auto& parameter : network.named_parameters()) {
    if (in_any(parameter.key(), frozen)) parameter.value().set_requires_grad(false);
  }
}

std::vector<std::pair<std::string, at::Tensor>> trained_parameters(torch::nn::Module& network) {
  std::vector<std::pair<std::string, at::Tensor>> result;
  for (const auto& parameter : network.named_parameters()) {
    if (parameter.value().requires_grad()) result.emplace_back(parameter.key(), parameter.value());
  }
  return result;
}

NamedTensors network_tensors(torch::nn::Module& network) {
  NamedTensors result;
  for (const auto& parameter : network.named_parameters())
    result[parameter.key()] = parameter.value();
  for (const auto& buffer : network.named_buffers()) result[buffer.key()] = buffer.value();
  return result;
}

void copy_tensors(const NamedTensors& to, const NamedTensors& from, const std::string& source) {
  std::vector<std::string> problems;
  for (const auto& [name, tensor] : to) {
    const auto found = from.find(name);
    if (found == from.end()) {
      problems.push_back("missing " + name);
    } else if (found->second.sizes() != tensor.sizes() ||
               found->second.scalar_type() != tensor.scalar_type()) {
      problems.push_back(name + ": " + difference(tensor, found->second));
    }
  }
  for (const auto& [name, ignored] : from) {
    if (!to.contains(name)) problems.push_back("unknown " + name);
  }
  if (!problems.empty()) throw FormatError(source + ": " + join(problems, "; "));
  const at::NoGradGuard no_gradient;
  for (const auto& [name, tensor] : to) at::Tensor(tensor).copy_(from.at(name));
}

BufferBackup::BufferBackup(torch::nn::Module& network) : buffers_(network.buffers()) {
  for (const at::Tensor& buffer : buffers_) copies_.push_back(buffer.clone());
}

void BufferBackup::save() {
  for (std::size_t i = 0; i < buffers_.size(); ++i) copies_[i].copy_(buffers_[i]);
}

void BufferBackup::restore() {
  for (std::size_t i = 0; i < buffers_.size(); ++i) buffers_[i].copy_(copies_[i]);
}

}  // namespace arbox::training
