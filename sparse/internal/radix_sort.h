#pragma once

#include <array>
#include <cstdint>
#include <utility>
#include <vector>

namespace arbox::sparse::internal {

/// A key with the row it belongs to.
struct Keyed {
  std::uint64_t key;
  std::int32_t row;
};

inline std::uint64_t key_of(const Keyed& item) { return item.key; }
inline std::uint64_t key_of(std::uint64_t item) { return item; }

/// Stable least-significant-digit radix sort of items whose keys use the lowest `bits` bits.
/// One more copy of the items is needed; sorted input costs one pass.
template <class Item>
void radix_sort(std::vector<Item>& items, int bits) {
  constexpr int kDigitBits = 11;
  constexpr std::uint64_t kMask = (1 << kDigitBits) - 1;
  bool sorted = true;
  for (std::size_t i = 1; i < items.size() && sorted; ++i) {
    sorted = key_of(items[i - 1]) <= key_of(items[i]);
  }
  if (sorted) return;
  std::vector<Item> other(items.size());
  for (int shift = 0; shift < bits; shift += kDigitBits) {
    std::array<std::uint32_t, (1 << kDigitBits)> starts{};
    for (const Item& item : items) ++starts[(key_of(item) >> shift) & kMask];
    std::uint32_t sum = 0;
    for (std::uint32_t& start : starts) sum += std::exchange(start, sum);
    for (const Item& item : items) other[starts[(key_of(item) >> shift) & kMask]++] = item;
    items.swap(other);
  }
}

}  // namespace arbox::sparse::internal
