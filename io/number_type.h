#pragma once

#include <cstddef>
#include <string_view>

namespace arbox::io {

/// Number formats that files hold. Booleans are one byte.
enum class NumberType {
  kBool,
  kInt8,
  kUint8,
  kInt16,
  kUint16,
  kInt32,
  kUint32,
  kInt64,
  kUint64,
  kFloat16,
  kFloat32,
  kFloat64
};

/// Bytes of one number.
std::size_t size_of(NumberType type);

/// A word for messages: "uint8", "float32".
std::string_view name_of(NumberType type);

/// True for the three float types.
bool is_floating(NumberType type);

/// IEEE half precision to single; exact.
float half_to_float(unsigned short bits);

}  // namespace arbox::io
