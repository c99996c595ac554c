#pragma once

#include <array>
#include <cstdint>

namespace arbox {

/// One block of the counter-based generator Philox4x32-10 (Salmon et al., SC 2011): four 32-bit
/// words that depend on key and counter alone. Equal inputs give equal words on every machine.
std::array<std::uint32_t, 4> philox(std::array<std::uint32_t, 4> counter,
                                    std::array<std::uint32_t, 2> key);

/// A stream of random numbers addressed by index: draw i is a function of (seed, object, purpose,
/// i) and of nothing else, so that results do not depend on threads, batches or order.
///
/// A value type of 32 bytes; copies are free and independent. `purpose` keeps apart the uses that
/// one object makes of randomness (give each use its own constant below 2^32).
class RandomStream {
 public:
  RandomStream(std::uint64_t seed, std::uint64_t object, std::uint32_t purpose)
      : seed_(seed), object_(object), purpose_(purpose) {}

  /// Uniform 128 bits of draw `index`; bits() is the first word.
  std::array<std::uint32_t, 4> words(std::uint32_t index) const;
  /// Uniform 32 bits of draw `index`.
  std::uint32_t bits(std::uint32_t index) const;
  /// Uniform in [0, 1), 53 random bits.
  double uniform(std::uint32_t index) const;
  /// Uniform in [low, high).
  double uniform(std::uint32_t index, double low, double high) const;
  /// Uniform integer in [0, count), count >= 1, without modulo bias beyond 2^-32.
  std::uint32_t below(std::uint32_t index, std::uint32_t count) const;
  /// Standard normal (Box-Muller).
  double normal(std::uint32_t index) const;

 private:
  std::uint64_t seed_;
  std::uint64_t object_;
  std::uint32_t purpose_;
};

}  // namespace arbox
