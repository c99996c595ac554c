#include "arbox/heads/internal/conditional_network.h"

#include <dnnl.h>

#include <algorithm>
#include <string>

#include "arbox/base/error.h"
#include "arbox/base/parallel.h"

namespace arbox::heads::internal {
namespace {

constexpr std::int64_t kRowsAtOnce = 64;

void add_bias_and_leak(std::span<float> rows, const float* bias, std::int32_t width, float leak,
                       int threads) {
  const auto count = static_cast<std::int64_t>(rows.size()) / width;
  parallel_for(count, kRowsAtOnce, threads, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t r = begin; r < end; ++r) {
      float* row = rows.data() + r * width;
      for (std::int32_t c = 0; c < width; ++c) {
        const float value = row[c] + bias[c];
        row[c] = value > 0.0f ? value : leak * value;
      }
    }
  });
}

void add_bias(std::span<float> rows, const float* bias, std::int32_t width, int threads) {
  add_bias_and_leak(rows, bias, width, 1.0f, threads);
}

}  // namespace

void multiply_transposed(std::int64_t rows, std::int64_t columns, std::int64_t inner,
                         const float* a, std::int64_t a_stride, const float* b,
                         std::int64_t b_stride, float* c) {
  if (rows == 0 || columns == 0) return;
  const dnnl_status_t status =
      dnnl_sgemm('N', 'T', rows, columns, inner, 1.0f, a, a_stride, b, b_stride, 0.0f, c, columns);
  if (status != dnnl_success) {
    throw NumericalError("oneDNN refused a product of " + std::to_string(rows) + " x " +
                         std::to_string(inner) + " by " + std::to_string(columns) + ", status " +
                         std::to_string(static_cast<int>(status)));
  }
}

ConditionalNetwork::ConditionalNetwork(std::span<const ComponentWeights> components, float leak,
                                       int threads)
    : components_(components), leak_(leak), threads_(threads), object_parts_(components.size()) {}

void ConditionalNetwork::set_features(const FeatureRows& features) {
  features_ = features;
  for (auto& part : object_parts_) part.clear();
}

void ConditionalNetwork::first_layer(const ComponentWeights& component, int index,
                                     const PrefixRows& rows) {
  const LayerWeights& layer = component.layers.front();
  std::vector<float>& part = object_parts_[index];
  if (part.empty() && features_.objects > 0) {
    part.resize(features_.objects * layer.out);
    multiply_transposed(features_.objects, layer.out, features_.width, features_.values,
                        features_.width, layer.weight, layer.in, part.data());
    add_bias(part, layer.bias, layer.out, threads_);
  }
  std::vector<float> columns(static_cast<std::size_t>(index) * layer.out);
  for (int j = 0; j < index; ++j) {
    for (std::int32_t c = 0; c < layer.out; ++c) {
      columns[static_cast<std::size_t>(j) * layer.out + c] =
          layer.weight[std::int64_t{c} * layer.in + features_.width + j];
    }
  }
  const auto count = static_cast<std::int64_t>(rows.objects.size());
  current_.resize(count * layer.out);
  const float leak = component.layers.size() > 1 ? leak_ : 1.0f;
  parallel_for(count, kRowsAtOnce, threads_, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t r = begin; r < end; ++r) {
      float* row = current_.data() + r * layer.out;
      std::copy_n(part.data() + std::int64_t{rows.objects[r]} * layer.out, layer.out, row);
      for (int j = 0; j < index; ++j) {
        const float value = rows.values[r * index + j];
        const float* column = columns.data() + static_cast<std::size_t>(j) * layer.out;
        for (std::int32_t c = 0; c < layer.out; ++c) row[c] += value * column[c];
      }
      for (std::int32_t c = 0; c < layer.out; ++c) row[c] = row[c] > 0 ? row[c] : leak * row[c];
    }
  });
}

std::span<const float> ConditionalNetwork::logits(int index, const PrefixRows& rows) {
  const ComponentWeights& component = components_[index];
  const auto count = static_cast<std::int64_t>(rows.objects.size());
  first_layer(component, index, rows);
  for (std::size_t l = 1; l < component.layers.size(); ++l) {
    const LayerWeights& layer = component.layers[l];
    next_.resize(count * layer.out);
    multiply_transposed(count, layer.out, layer.in, current_.data(), layer.in, layer.weight,
                        layer.in, next_.data());
    const bool last = l + 1 == component.layers.size();
    add_bias_and_leak(next_, layer.bias, layer.out, last ? 1.0f : leak_, threads_);
    current_.swap(next_);
  }
  return current_;
}

}  // namespace arbox::heads::internal
