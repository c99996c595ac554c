#include "arbox/training/weights_file.h"

#include <ATen/ops/lerp.h>

#include <algorithm>

#include "arbox/base/error.h"
#include "arbox/detectors/model_file.h"
#include "arbox/io/model_archive.h"
#include "arbox/training/durable_file.h"
#include "arbox/training/network_state.h"

namespace arbox::training {
namespace {

constexpr const char* kWeightsKind = "training_weights";
/// Where a checkpoint keeps what a model keeps under its plain name.
constexpr const char* kNetwork = "network/";

at::Tensor rounded(const std::string& name, const at::Tensor& tensor) {
  if (!tensor.is_floating_point()) return tensor;
  at::Tensor half = tensor.detach().to(at::kHalf);
  if (!half.isfinite().all().item<bool>()) {
    throw NumericalError("save_weights: " + name + " has numbers that float16 cannot hold");
  }
  return half;
}

NamedTensors tensors_in(const io::ModelArchive& archive) {
  NamedTensors tensors;
  for (const auto& [name, record] : archive.records) {
    if (name.starts_with(kNetwork)) {
      tensors[name.substr(std::string(kNetwork).size())] = detectors::to_tensor(record, name);
    } else if (name.find('/') == std::string::npos) {
      tensors[name] = detectors::to_tensor(record, name);
    }
  }
  return tensors;
}

NamedTensors without(NamedTensors tensors, const std::vector<std::string>& parts) {
  std::erase_if(tensors, [&](const auto& entry) {
    return std::any_of(parts.begin(), parts.end(),
                       [&](const std::string& part) { return in_part(entry.first, part); });
  });
  return tensors;
}

/// What a file holds, fractions in the type that `to` has under the same name.
NamedTensors tensors_like(const NamedTensors& to, const std::filesystem::path& path,
                          const std::vector<std::string>& except) {
  NamedTensors from = without(tensors_in(io::read_model_archive(path)), except);
  for (auto& [name, tensor] : from) {
    const auto target = to.find(name);
    if (target != to.end() && tensor.is_floating_point()) {
      tensor = tensor.to(target->second.scalar_type());
    }
  }
  return from;
}

}  // namespace

void save_weights(torch::nn::Module& network, const std::filesystem::path& path) {
  io::ModelArchive archive;
  archive.kind = kWeightsKind;
  for (const auto& [name, tensor] : network_tensors(network)) {
    archive.records[name] = detectors::to_record(rounded(name, tensor));
  }
  write_durably(path, io::encode_model_archive(archive, true));
}

void load_weights(torch::nn::Module& network, const std::filesystem::path& path,
                  const std::vector<std::string>& except) {
  const NamedTensors to = without(network_tensors(network), except);
  copy_tensors(to, tensors_like(to, path, except), path.string());
}

void average_weights(torch::nn::Module& network, const std::filesystem::path& path, double share,
                     const std::vector<std::string>& except) {
  if (!(share >= 0 && share <= 1)) {
    throw InvalidArgument("average_weights: expected a share from 0 to 1, got " +
                          std::to_string(share));
  }
  const NamedTensors to = without(network_tensors(network), except);
  NamedTensors from = tensors_like(to, path, except);
  for (auto& [name, tensor] : from) {
    const auto own = to.find(name);
    if (own == to.end() || own->second.sizes() != tensor.sizes()) continue;
    tensor = tensor.is_floating_point() ? at::lerp(own->second.detach(), tensor, share)
                                        : own->second.clone();
  }
  copy_tensors(to, from, path.string());
}

}  // namespace arbox::training
