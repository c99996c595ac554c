#include "arbox/heads/internal/conditional_network.h"

#include <algorithm>
#include <utility>

#include "arbox/base/parallel.h"
#include "arbox/heads/internal/mlp_kernel.h"

namespace arbox::heads::internal {
namespace {

// The activations of a block of rows stay in the second-level cache together with a panel of
// weights; more rows read the weights less often.
constexpr std::int64_t kBlockRows = 96;
constexpr std::int64_t kBlockFloats = 98304;
constexpr std::int64_t kTileRows = 6;

std::int64_t divide_up(std::int64_t a, std::int64_t b) { return (a + b - 1) / b; }

/// Rows of a block, such that every thread gets about as much.
std::int64_t block_rows(std::int64_t rows, std::int64_t most, int threads) {
  const std::int64_t workers = threads > 0 ? threads : default_threads();
  const std::int64_t blocks = divide_up(divide_up(rows, most), workers) * workers;
  return std::min(most, divide_up(divide_up(rows, blocks), kTileRows) * kTileRows);
}

/// `rows` rows of input through a layer; the output has the layer's columns.
void run_layer(const PackedLayer& layer, const float* input, std::int64_t input_stride,
               float* output, std::int64_t rows, float leak) {
  mlp_kernels().layer({.input = input,
                       .input_stride = input_stride,
                       .output = output,
                       .output_stride = layer.columns,
                       .rows = rows,
                       .weight = layer.weight.data(),
                       .bias = layer.bias.data(),
                       .in = layer.in,
                       .columns = layer.columns,
                       .leak = leak});
}

}  // namespace

ConditionalNetwork::ConditionalNetwork(const PackedNetwork& network, int threads)
    : network_(network),
      threads_(threads),
      most_rows_(std::clamp(kBlockFloats / std::max<std::int64_t>(network.widest(), 1), kTileRows,
                            kBlockRows)),
      object_parts_(network.size()) {}

void ConditionalNetwork::set_features(const FeatureRows& features) {
  features_ = features;
  for (auto& part : object_parts_) part.clear();
}

const float* ConditionalNetwork::object_part(std::int32_t index) {
  AlignedFloats& part = object_parts_[index];
  if (!part.empty() || features_.objects == 0) return part.data();
  const PackedLayer& layer = network_[index].features;
  part.resize(features_.objects * layer.columns);
  const std::int64_t grain = block_rows(features_.objects, kBlockRows, threads_);
  parallel_for(features_.objects, grain, threads_, [&](std::int64_t begin, std::int64_t end) {
    run_layer(layer, features_.values + begin * features_.width, features_.width,
              part.data() + begin * layer.columns, end - begin, 1.0f);
  });
  return part.data();
}

LogitBlock ConditionalNetwork::evaluate_block(const PackedComponent& component,
                                              const PrefixRows& rows, std::int32_t index,
                                              std::int64_t begin, std::int64_t end,
                                              Workspace& workspace) const {
  std::int32_t columns = component.features.columns;
  const float* part = object_parts_[index].data();
  for (std::int64_t r = begin; r < end; ++r) {
    mlp_kernels().add_prefix({.base = part + std::int64_t{rows.objects[r]} * columns,
                              .values = rows.values.data() + r * index,
                              .count = index,
                              .columns_of_values = component.prefix.data(),
                              .columns = columns,
                              .leak = component.rest.empty() ? 1.0f : network_.leak(),
                              .output = workspace.current.data() + (r - begin) * columns});
  }
  for (const PackedLayer& layer : component.rest) {
    run_layer(layer, workspace.current.data(), columns, workspace.next.data(), end - begin,
              &layer == &component.rest.back() ? 1.0f : network_.leak());
    columns = layer.columns;
    workspace.current.swap(workspace.next);
  }
  return {begin, end - begin, workspace.current.data(), columns};
}

void ConditionalNetwork::evaluate(std::int32_t index, const PrefixRows& rows,
                                  const std::function<void(const LogitBlock&)>& visit) {
  const auto count = static_cast<std::int64_t>(rows.objects.size());
  if (count == 0) return;
  object_part(index);
  const PackedComponent& component = network_[index];
  parallel_for(count, block_rows(count, most_rows_, threads_), threads_,
               [&](std::int64_t begin, std::int64_t end) {
                 Workspace workspace = take_workspace();
                 visit(evaluate_block(component, rows, index, begin, end, workspace));
                 return_workspace(std::move(workspace));
               });
}

ConditionalNetwork::Workspace ConditionalNetwork::take_workspace() {
  {
    const std::scoped_lock lock(mutex_);
    if (!workspaces_.empty()) {
      Workspace workspace = std::move(workspaces_.back());
      workspaces_.pop_back();
      return workspace;
    }
  }
  const std::int64_t size = most_rows_ * network_.widest();
  return {AlignedFloats(size), AlignedFloats(size)};
}

void ConditionalNetwork::return_workspace(Workspace workspace) {
  const std::scoped_lock lock(mutex_);
  workspaces_.push_back(std::move(workspace));
}

}  // namespace arbox::heads::internal
