#include "hashed_kernel_map.h"

#include <algorithm>
#include <bit>
#include <limits>

#include "arbox/base/parallel.h"

namespace arbox::benchmarks {
namespace {

using sparse::Coordinate;
using sparse::KernelMap;

constexpr std::int64_t kElements = 27, kRowsAtOnce = 4096;
constexpr std::uint64_t kEmpty = std::numeric_limits<std::uint64_t>::max();

class Table {
 public:
  explicit Table(const std::vector<std::uint64_t>& keys)
      : shift_(64 - std::bit_width(2 * keys.size())), slots_(std::size_t{1} << (64 - shift_)) {
    for (std::size_t row = 0; row < keys.size(); ++row) {
      std::size_t place = first(keys[row]);
      while (slots_[place].key != kEmpty) place = next(place);
      slots_[place] = {keys[row], static_cast<std::int32_t>(row)};
    }
  }
  std::int32_t find(std::uint64_t key) const {
    std::size_t place = first(key);
    while (slots_[place].key != key && slots_[place].key != kEmpty) place = next(place);
    return slots_[place].key == key ? slots_[place].row : -1;
  }

 private:
  struct Slot {
    std::uint64_t key = kEmpty;
    std::int32_t row = -1;
  };
  std::size_t first(std::uint64_t key) const { return (key * 0x9E3779B97F4A7C15u) >> shift_; }
  std::size_t next(std::size_t place) const { return (place + 1) & (slots_.size() - 1); }

  int shift_;
  std::vector<Slot> slots_;
};

}  // namespace

KernelMap hashed_kernel_map(std::span<const Coordinate> coordinates, int threads) {
  const auto [low, high] = sparse::bounds(coordinates);
  const sparse::KeyLayout layout(low, high, 1);
  const auto count = static_cast<std::int64_t>(coordinates.size());
  std::vector<std::uint64_t> keys(coordinates.size());
  std::transform(coordinates.begin(), coordinates.end(), keys.begin(),
                 [&](const Coordinate& c) { return layout.pack(c); });
  const Table table(keys);

  std::vector<std::int32_t> found(kElements * count);
  std::vector<std::int64_t> part_counts(kElements * ((count + kRowsAtOnce - 1) / kRowsAtOnce));
  parallel_for(count, kRowsAtOnce, threads, [&](std::int64_t begin, std::int64_t end) {
    std::int64_t* counts = part_counts.data() + kElements * (begin / kRowsAtOnce);
    for (std::int64_t k = 0; k < kElements; ++k) {
      const std::int64_t delta = layout.delta(static_cast<std::int32_t>(k / 9 - 1),
                                              static_cast<std::int32_t>(k / 3 % 3 - 1),
                                              static_cast<std::int32_t>(k % 3 - 1));
      for (std::int64_t row = begin; row < end; ++row) {
        const std::int32_t other = table.find(keys[row] + static_cast<std::uint64_t>(delta));
        found[k * count + row] = other;
        counts[k] += other >= 0;
      }
    }
  });

  KernelMap map;
  map.starts.assign(kElements + 1, 0);
  for (std::size_t i = 0; i < part_counts.size(); ++i) {
    map.starts[1 + i % kElements] += part_counts[i];
  }
  for (std::int64_t k = 0; k < kElements; ++k) map.starts[k + 1] += map.starts[k];
  map.inputs.resize(map.starts.back());
  map.outputs.resize(map.starts.back());
  parallel_for(kElements, 1, threads, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t k = begin; k < end; ++k) {
      std::int64_t place = map.starts[k];
      for (std::int64_t row = 0; row < count; ++row) {
        if (found[k * count + row] < 0) continue;
        map.inputs[place] = found[k * count + row];
        map.outputs[place++] = static_cast<std::int32_t>(row);
      }
    }
  });
  return map;
}

}  // namespace arbox::benchmarks
