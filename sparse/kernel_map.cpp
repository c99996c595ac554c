#include "arbox/sparse/kernel_map.h"

#include <algorithm>
#include <cstdlib>
#include <span>

#include "arbox/base/error.h"
#include "arbox/base/parallel.h"

namespace arbox::sparse {
namespace {

struct PairList {
  std::vector<std::int32_t> inputs, outputs;
};

/// Offsets with equal x and y, so that one merge over the sorted lists serves all of them.
struct Column {
  std::int64_t delta = 0;           // key difference of the lowest offset
  std::vector<std::int32_t> steps;  // z above the lowest, ascending
  std::vector<int> elements;
};

std::vector<Column> columns_of(const KernelGeometry& geometry, const KeyLayout& layout,
                               std::size_t count) {
  std::vector<int> order(count);
  for (std::size_t k = 0; k < count; ++k) order[k] = static_cast<int>(k);
  std::sort(order.begin(), order.end(),
            [&](int a, int b) { return geometry.offsets[a] < geometry.offsets[b]; });
  std::vector<Column> columns;
  const std::array<std::int32_t, 3>* lowest = nullptr;
  for (const int k : order) {
    const auto& offset = geometry.offsets[k];
    if (lowest == nullptr || (*lowest)[0] != offset[0] || (*lowest)[1] != offset[1]) {
      lowest = &offset;
      columns.emplace_back().delta = layout.delta(offset[0], offset[1], offset[2]);
    }
    columns.back().steps.push_back(offset[2] - (*lowest)[2]);
    columns.back().elements.push_back(k);
  }
  return columns;
}

void merge(const Column& column, std::span<const std::uint64_t> inputs,
           std::span<const std::uint64_t> targets, std::vector<PairList>& pairs) {
  const std::size_t width = column.steps.size();
  const std::size_t most = std::min(inputs.size(), targets.size());
  std::vector<std::int32_t*> next_input(width), next_output(width);
  for (std::size_t e = 0; e < width; ++e) {
    PairList& list = pairs[column.elements[e]];
    list.inputs.resize(most);
    list.outputs.resize(most);
    next_input[e] = list.inputs.data();
    next_output[e] = list.outputs.data();
  }
  const std::uint64_t last_step = static_cast<std::uint64_t>(column.steps.back());
  const std::uint64_t* const end = inputs.data() + inputs.size();
  const std::uint64_t* from = inputs.data();
  for (std::size_t o = 0; o < targets.size(); ++o) {
    const std::uint64_t target = targets[o] + static_cast<std::uint64_t>(column.delta);
    while (from != end && *from < target) ++from;
    std::size_t e = 0;
    for (const std::uint64_t* key = from; key != end && *key - target <= last_step; ++key) {
      const auto step = static_cast<std::int32_t>(*key - target);
      while (column.steps[e] < step) ++e;
      if (column.steps[e] != step) continue;
      *next_input[e]++ = static_cast<std::int32_t>(key - inputs.data());
      *next_output[e]++ = static_cast<std::int32_t>(o);
    }
  }
  for (std::size_t e = 0; e < width; ++e) {
    PairList& list = pairs[column.elements[e]];
    list.inputs.resize(next_input[e] - list.inputs.data());
    list.outputs.resize(next_output[e] - list.outputs.data());
  }
}

std::vector<Coordinate> targets_of(const SortedCoordinates& outputs,
                                   const KernelGeometry& geometry) {
  std::vector<Coordinate> targets = outputs.coordinates;
  for (Coordinate& c : targets) {
    c.x = c.x * geometry.scale[0] + geometry.origin[0];
    c.y = c.y * geometry.scale[1] + geometry.origin[1];
    c.z = c.z * geometry.scale[2] + geometry.origin[2];
  }
  return targets;
}

bool mirrors_itself(const KernelGeometry& geometry, const SortedCoordinates& inputs,
                    const SortedCoordinates& outputs) {
  const std::size_t count = geometry.offsets.size();
  if (&inputs != &outputs || count % 2 == 0) return false;
  if (geometry.scale != std::array<std::int32_t, 3>{1, 1, 1} ||
      geometry.origin != std::array<std::int32_t, 3>{0, 0, 0}) {
    return false;
  }
  for (std::size_t k = 0; k < count; ++k) {
    for (int axis = 0; axis < 3; ++axis) {
      if (geometry.offsets[k][axis] != -geometry.offsets[count - 1 - k][axis]) return false;
    }
  }
  return true;
}

std::int32_t margin_of(const KernelGeometry& geometry) {
  std::int32_t margin = 0;
  for (const auto& offset : geometry.offsets) {
    for (const std::int32_t value : offset) margin = std::max(margin, std::abs(value));
  }
  return margin;
}

KernelMap concatenate(std::vector<PairList> pairs, int threads) {
  KernelMap map;
  map.starts.push_back(0);
  for (const PairList& list : pairs) {
    map.starts.push_back(map.starts.back() + static_cast<std::int64_t>(list.inputs.size()));
  }
  map.inputs.resize(map.starts.back());
  map.outputs.resize(map.starts.back());
  parallel_for(static_cast<std::int64_t>(pairs.size()), 1, threads,
               [&](std::int64_t begin, std::int64_t end) {
                 for (std::int64_t k = begin; k < end; ++k) {
                   std::copy(pairs[k].inputs.begin(), pairs[k].inputs.end(),
                             map.inputs.begin() + map.starts[k]);
                   std::copy(pairs[k].outputs.begin(), pairs[k].outputs.end(),
                             map.outputs.begin() + map.starts[k]);
                 }
               });
  return map;
}

void mirror(std::vector<PairList>& pairs, std::int64_t voxels) {
  const std::size_t middle = pairs.size() / 2;
  PairList& center = pairs[middle];
  center.inputs.resize(voxels);
  for (std::int64_t i = 0; i < voxels; ++i) center.inputs[i] = static_cast<std::int32_t>(i);
  center.outputs = center.inputs;
  for (std::size_t k = 0; k < middle; ++k) {
    pairs[pairs.size() - 1 - k] = {pairs[k].outputs, pairs[k].inputs};
  }
}

}  // namespace

KernelMap build_kernel_map(const SortedCoordinates& inputs, const SortedCoordinates& outputs,
                           const KernelGeometry& geometry, int threads) {
  std::vector<PairList> pairs(geometry.offsets.size());
  if (inputs.rows.empty() || outputs.rows.empty() || pairs.empty()) {
    return concatenate(std::move(pairs), threads);
  }
  const bool symmetric = mirrors_itself(geometry, inputs, outputs);
  const std::vector<Coordinate> targets = targets_of(outputs, geometry);
  const CoordinateBounds in = bounds(inputs.coordinates), out = bounds(targets);
  const KeyLayout layout({std::min(in.low.batch, out.low.batch), std::min(in.low.x, out.low.x),
                          std::min(in.low.y, out.low.y), std::min(in.low.z, out.low.z)},
                         {std::max(in.high.batch, out.high.batch), std::max(in.high.x, out.high.x),
                          std::max(in.high.y, out.high.y), std::max(in.high.z, out.high.z)},
                         margin_of(geometry));
  const auto pack = [&](const std::vector<Coordinate>& coordinates) {
    std::vector<std::uint64_t> keys(coordinates.size());
    std::transform(coordinates.begin(), coordinates.end(), keys.begin(),
                   [&](const Coordinate& c) { return layout.pack(c); });
    return keys;
  };
  const std::vector<std::uint64_t> input_keys = pack(inputs.coordinates);
  const std::vector<std::uint64_t> target_keys =
      symmetric ? std::vector<std::uint64_t>{} : pack(targets);
  const std::span<const std::uint64_t> target_view = symmetric ? input_keys : target_keys;
  const std::vector<Column> columns =
      columns_of(geometry, layout, symmetric ? pairs.size() / 2 : pairs.size());
  parallel_for(static_cast<std::int64_t>(columns.size()), 1, threads,
               [&](std::int64_t begin, std::int64_t end) {
                 for (std::int64_t c = begin; c < end; ++c) {
                   merge(columns[c], input_keys, target_view, pairs);
                 }
               });
  if (symmetric) mirror(pairs, static_cast<std::int64_t>(inputs.rows.size()));
  return concatenate(std::move(pairs), threads);
}

}  // namespace arbox::sparse
