#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>

#include "arbox/base/error.h"
#include "arbox/io/number_type.h"

namespace arbox::io::internal {

static_assert(std::endian::native == std::endian::little);

/// A stored IEEE half number.
struct Half {
  std::uint16_t bits = 0;
  explicit operator float() const { return half_to_float(bits); }
  explicit operator double() const { return half_to_float(bits); }
};

template <class T>
T load_number(const std::byte* from, bool big_endian) {
  T value;
  if (!big_endian) {
    std::memcpy(&value, from, sizeof value);
    return value;
  }
  std::byte reversed[sizeof(T)];
  for (std::size_t i = 0; i < sizeof(T); ++i) reversed[i] = from[sizeof(T) - 1 - i];
  std::memcpy(&value, reversed, sizeof value);
  return value;
}

/// Calls function(T{}) with the C++ type that stands for `type`.
template <class Function>
auto with_type(NumberType type, Function&& function) {
  switch (type) {
    case NumberType::kBool:
    case NumberType::kUint8:
      return function(std::uint8_t{});
    case NumberType::kInt8:
      return function(std::int8_t{});
    case NumberType::kInt16:
      return function(std::int16_t{});
    case NumberType::kUint16:
      return function(std::uint16_t{});
    case NumberType::kInt32:
      return function(std::int32_t{});
    case NumberType::kUint32:
      return function(std::uint32_t{});
    case NumberType::kInt64:
      return function(std::int64_t{});
    case NumberType::kUint64:
      return function(std::uint64_t{});
    case NumberType::kFloat16:
      return function(Half{});
    case NumberType::kFloat32:
      return function(float{});
    case NumberType::kFloat64:
      return function(double{});
  }
  throw InvalidArgument("with_type: unknown number type");
}

}  // namespace arbox::io::internal
