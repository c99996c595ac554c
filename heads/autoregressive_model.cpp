#include "arbox/heads/autoregressive_model.h"

#include <ATen/TensorOperators.h>

#include <utility>

#include "arbox/heads/internal/component_math.h"
#include "arbox/heads/internal/packed_network.h"

namespace arbox::heads {
namespace {

using Components = std::vector<AutoregressiveModel::Layers>;

/// Calls visit(tensor) for every parameter.
template <class Visit>
void for_parameters(const Components& components, const Visit& visit) {
  for (const auto& layers : components) {
    for (const auto& layer : layers) {
      visit(layer.weight);
      visit(layer.bias);
    }
  }
}

/// Address and version of every parameter; -1 for those that LibTorch keeps no version of.
std::vector<std::int64_t> versions(const Components& components) {
  std::vector<std::int64_t> result;
  for_parameters(components, [&](const at::Tensor& tensor) {
    result.push_back(reinterpret_cast<std::intptr_t>(tensor.data_ptr()));
    result.push_back(tensor.is_inference() ? -1 : tensor._version());
  });
  return result;
}

}  // namespace

AutoregressiveModel::AutoregressiveModel(std::shared_ptr<const BoxCodec> codec,
                                         CircularEnds circular_ends, Components components,
                                         double leak, int threads)
    : codec_(std::move(codec)),
      circular_ends_(circular_ends),
      components_(std::move(components)),
      versions_(versions(components_)),
      leak_(leak),
      threads_(threads) {}

AutoregressiveModel::~AutoregressiveModel() = default;

const internal::PackedNetwork& AutoregressiveModel::network() const {
  std::call_once(once_, [this] {
    std::vector<at::Tensor> kept;
    const auto keep = [&](const at::Tensor& tensor) {
      kept.push_back(tensor.detach().to(at::kFloat).contiguous());
      return kept.back().data_ptr<float>();
    };
    std::vector<internal::ComponentWeights> weights;
    for (std::size_t i = 0; i < components_.size(); ++i) {
      const Component& described = codec_->components()[i];
      weights.push_back({.layers = {},
                         .low = described.low,
                         .step = described.step(),
                         .circular = described.circular});
      for (const Layer& layer : components_[i]) {
        weights.back().layers.push_back({keep(layer.weight), keep(layer.bias),
                                         static_cast<std::int32_t>(layer.weight.size(1)),
                                         static_cast<std::int32_t>(layer.weight.size(0))});
      }
      weights.back().layers.back().out =
          static_cast<std::int32_t>(internal::usable_bins(described, circular_ends_));
    }
    network_ = std::make_unique<const internal::PackedNetwork>(weights, static_cast<float>(leak_),
                                                               threads_);
  });
  return *network_;
}

bool AutoregressiveModel::is_of(const Components& components) const {
  bool known = true;
  for_parameters(components, [&](const at::Tensor& tensor) {
    if (tensor.is_inference()) known = false;
  });
  return known && versions(components) == versions_;
}

}  // namespace arbox::heads
