#pragma once

#include <cmath>
#include <cstdint>
#include <list>
#include <vector>

#include "arbox/base/random.h"
#include "arbox/heads/internal/packed_network.h"

namespace arbox::testing {

constexpr float kLeak = 0.1f;

/// MLPs with random weights, one a component; bins are 0, 0.5, 1, ... apart.
struct RandomNetwork {
  std::list<std::vector<float>> storage;
  std::vector<heads::internal::ComponentWeights> components;

  heads::internal::PackedNetwork packed() const { return {components, kLeak}; }
};

inline std::vector<float> normal_floats(std::int64_t count, std::uint64_t seed, double deviation) {
  std::vector<float> values(count);
  const RandomStream random(seed, 0, 0);
  for (std::int64_t i = 0; i < count; ++i) {
    values[i] = static_cast<float>(deviation * random.normal(static_cast<std::uint32_t>(i)));
  }
  return values;
}

/// `gain` scales the weights of the last layer: how sure the network is.
inline RandomNetwork random_network(std::int32_t features, const std::vector<std::int32_t>& hidden,
                                    const std::vector<std::int32_t>& bins, std::uint64_t seed,
                                    double gain = 2.0) {
  RandomNetwork network;
  for (std::size_t i = 0; i < bins.size(); ++i) {
    heads::internal::ComponentWeights component{.layers = {}, .low = 0.0, .step = 0.5};
    std::vector<std::int32_t> widths = hidden;
    widths.push_back(bins[i]);
    std::int32_t in = features + static_cast<std::int32_t>(i);
    for (std::size_t l = 0; l < widths.size(); ++l) {
      const double scale = l + 1 == widths.size() ? gain : 1.0;
      network.storage.push_back(
          normal_floats(std::int64_t{in} * widths[l], ++seed, scale / std::sqrt(in)));
      const float* weight = network.storage.back().data();
      network.storage.push_back(normal_floats(widths[l], ++seed, 0.3));
      component.layers.push_back({weight, network.storage.back().data(), in, widths[l]});
      in = widths[l];
    }
    network.components.push_back(component);
  }
  return network;
}

/// log softmax of one component's logits, in double, the plain way.
inline std::vector<double> naive_log_probabilities(
    const heads::internal::ComponentWeights& component, std::vector<double> input) {
  for (const auto& layer : component.layers) {
    std::vector<double> output(layer.out);
    for (std::int32_t o = 0; o < layer.out; ++o) {
      output[o] = layer.bias[o];
      for (std::int32_t k = 0; k < layer.in; ++k) {
        output[o] += input[k] * layer.weight[std::int64_t{o} * layer.in + k];
      }
      if (&layer != &component.layers.back() && output[o] < 0) output[o] *= kLeak;
    }
    input = output;
  }
  double top = input[0], sum = 0.0;
  for (const double logit : input) top = std::max(top, logit);
  for (const double logit : input) sum += std::exp(logit - top);
  for (double& logit : input) logit -= top + std::log(sum);
  return input;
}

struct EnumeratedVector {
  std::vector<std::int32_t> bins;
  double log_probability = 0.0;
};

/// Every vector that continues `known` values, in lexicographic order of its bins. `temperature`
/// sharpens or flattens each conditional.
inline std::vector<EnumeratedVector> enumerate(const RandomNetwork& network, const float* features,
                                               const std::vector<double>& known = {},
                                               double temperature = 1.0) {
  std::vector<EnumeratedVector> live(1);
  const std::int32_t width = network.components.front().layers.front().in;
  for (std::size_t i = known.size(); i < network.components.size(); ++i) {
    const auto& component = network.components[i];
    std::vector<EnumeratedVector> next;
    for (const EnumeratedVector& vector : live) {
      std::vector<double> input(features, features + width);
      input.insert(input.end(), known.begin(), known.end());
      for (std::size_t j = known.size(); j < i; ++j) {
        input.push_back(
            static_cast<float>(network.components[j].low +
                               network.components[j].step * vector.bins[j - known.size()]));
      }
      std::vector<double> log_probability = naive_log_probabilities(component, input);
      double sum = 0.0;
      for (const double one : log_probability) sum += std::exp(one / temperature);
      for (std::int32_t bin = 0; bin < component.bins(); ++bin) {
        next.push_back(vector);
        next.back().bins.push_back(bin);
        next.back().log_probability += log_probability[bin] / temperature - std::log(sum);
      }
    }
    live = std::move(next);
  }
  return live;
}

}  // namespace arbox::testing
