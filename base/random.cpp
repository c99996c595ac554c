#include "arbox/base/random.h"

#include <cmath>
#include <numbers>

namespace arbox {
namespace {

constexpr double kUnit53 = 1.0 / 9007199254740992.0;

double unit(std::uint32_t high, std::uint32_t low) {
  const std::uint64_t bits = (static_cast<std::uint64_t>(high) << 32 | low) >> 11;
  return static_cast<double>(bits) * kUnit53;
}

}  // namespace

std::array<std::uint32_t, 4> philox(std::array<std::uint32_t, 4> counter,
                                    std::array<std::uint32_t, 2> key) {
  for (int round = 0; round < 10; ++round) {
    const std::uint64_t a = std::uint64_t{0xD2511F53} * counter[0];
    const std::uint64_t b = std::uint64_t{0xCD9E8D57} * counter[2];
    counter = {
        static_cast<std::uint32_t>(b >> 32) ^ counter[1] ^ key[0], static_cast<std::uint32_t>(b),
        static_cast<std::uint32_t>(a >> 32) ^ counter[3] ^ key[1], static_cast<std::uint32_t>(a)};
    key[0] += 0x9E3779B9;
    key[1] += 0xBB67AE85;
  }
  return counter;
}

std::array<std::uint32_t, 4> RandomStream::words(std::uint32_t index) const {
  return philox({index, purpose_, static_cast<std::uint32_t>(object_),
                 static_cast<std::uint32_t>(object_ >> 32)},
                {static_cast<std::uint32_t>(seed_), static_cast<std::uint32_t>(seed_ >> 32)});
}

std::uint32_t RandomStream::bits(std::uint32_t index) const { return words(index)[0]; }

double RandomStream::uniform(std::uint32_t index) const {
  const auto drawn = words(index);
  return unit(drawn[0], drawn[1]);
}

double RandomStream::uniform(std::uint32_t index, double low, double high) const {
  return low + (high - low) * uniform(index);
}

std::uint32_t RandomStream::below(std::uint32_t index, std::uint32_t count) const {
  return static_cast<std::uint32_t>((std::uint64_t{bits(index)} * count) >> 32);
}

double RandomStream::normal(std::uint32_t index) const {
  const auto drawn = words(index);
  const double radius = std::sqrt(-2.0 * std::log(1.0 - unit(drawn[0], drawn[1])));
  return radius * std::cos(2.0 * std::numbers::pi * unit(drawn[2], drawn[3]));
}

}  // namespace arbox
