#include "arbox/io/number_type.h"

#include <cmath>
#include <limits>

#include "arbox/base/error.h"

namespace arbox::io {

std::size_t size_of(NumberType type) {
  switch (type) {
    case NumberType::kBool:
    case NumberType::kInt8:
    case NumberType::kUint8:
      return 1;
    case NumberType::kInt16:
    case NumberType::kUint16:
    case NumberType::kFloat16:
      return 2;
    case NumberType::kInt32:
    case NumberType::kUint32:
    case NumberType::kFloat32:
      return 4;
    case NumberType::kInt64:
    case NumberType::kUint64:
    case NumberType::kFloat64:
      return 8;
  }
  throw InvalidArgument("size_of: unknown number type");
}

std::string_view name_of(NumberType type) {
  constexpr std::string_view kNames[] = {"bool",   "int8",    "uint8",   "int16",
                                         "uint16", "int32",   "uint32",  "int64",
                                         "uint64", "float16", "float32", "float64"};
  return kNames[static_cast<int>(type)];
}

bool is_floating(NumberType type) {
  return type == NumberType::kFloat16 || type == NumberType::kFloat32 ||
         type == NumberType::kFloat64;
}

float half_to_float(unsigned short bits) {
  const int exponent = (bits >> 10) & 31;
  const int fraction = bits & 1023;
  float magnitude = 0.0F;
  if (exponent == 31) {
    magnitude = fraction == 0 ? std::numeric_limits<float>::infinity()
                              : std::numeric_limits<float>::quiet_NaN();
  } else if (exponent == 0) {
    magnitude = std::ldexp(static_cast<float>(fraction), -24);
  } else {
    magnitude = std::ldexp(static_cast<float>(fraction + 1024), exponent - 25);
  }
  return (bits & 0x8000) != 0 ? -magnitude : magnitude;
}

}  // namespace arbox::io
