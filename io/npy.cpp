#include "arbox/io/npy.h"

#include <cmath>
#include <limits>
#include <type_traits>

#include "arbox/base/error.h"
#include "arbox/io/file.h"
#include "arbox/io/internal/load_number.h"
#include "arbox/io/internal/npy_description.h"

namespace arbox::io {
namespace {

template <class To, class From>
To converted(From from, std::size_t index) {
  if constexpr (std::is_floating_point_v<To>) {
    return static_cast<To>(from);
  } else {
    bool fits = false;
    if constexpr (std::is_integral_v<From>) {
      fits = std::in_range<To>(from);
    } else {
      const auto number = static_cast<double>(from);
      // The upper limit of a 64-bit type rounds up to a power of two as a double, hence "<".
      fits = number == std::trunc(number) &&
             number >= static_cast<double>(std::numeric_limits<To>::min()) &&
             number < static_cast<double>(std::numeric_limits<To>::max()) + 1.0;
    }
    if (!fits) {
      throw InvalidArgument("NpyArray::values: number " + std::to_string(index) + " is " +
                            std::to_string(static_cast<double>(from)) +
                            ", which the integer type asked for cannot hold");
    }
    return static_cast<To>(
        static_cast<std::conditional_t<std::is_integral_v<From>, From, double>>(from));
  }
}

template <class T>
constexpr NumberType number_type_of() {
  if constexpr (std::is_same_v<T, float>) return NumberType::kFloat32;
  if constexpr (std::is_same_v<T, double>) return NumberType::kFloat64;
  if constexpr (std::is_same_v<T, std::int32_t>) return NumberType::kInt32;
  if constexpr (std::is_same_v<T, std::int64_t>) return NumberType::kInt64;
  if constexpr (std::is_same_v<T, std::uint32_t>) return NumberType::kUint32;
  return NumberType::kUint8;
}

std::string_view description(NumberType type) {
  constexpr std::string_view kWords[] = {"|b1", "|i1", "|u1", "<i2", "<u2", "<i4",
                                         "<u4", "<i8", "<u8", "<f2", "<f4", "<f8"};
  return kWords[static_cast<int>(type)];
}

}  // namespace

template <class T>
std::vector<T> NpyArray::values() const {
  const auto* from = reinterpret_cast<const std::byte*>(data_.data());
  std::vector<T> result(size());
  internal::with_type(header_.type, [&](auto stored) {
    using Stored = decltype(stored);
    internal::FortranOrder order(header_.shape);
    for (std::size_t i = 0; i < result.size(); ++i) {
      const std::size_t at = header_.fortran_order ? order.position() : i;
      const auto number =
          internal::load_number<Stored>(from + at * sizeof(Stored), header_.big_endian);
      result[i] = converted<T>(number, i);
      if (header_.fortran_order) order.advance();
    }
  });
  return result;
}

NpyArray parse_npy(std::string_view bytes, const std::string& name) {
  NpyHeader header = parse_npy_header(bytes, name);
  std::string data(bytes.substr(header.data_offset, header.count() * size_of(header.type)));
  return {std::move(header), std::move(data)};
}

NpyArray read_npy(const std::filesystem::path& path) {
  return parse_npy(read_file(path), path.string());
}

std::string encode_npy(NumberType type, const std::vector<std::size_t>& shape,
                       std::string_view data) {
  const std::size_t count = NpyHeader{.shape = shape}.count();
  if (data.size() % size_of(type) != 0 || count != data.size() / size_of(type)) {
    throw InvalidArgument("encode_npy: the shape holds " + std::to_string(count) + " numbers of " +
                          std::string(name_of(type)) + ", got " + std::to_string(data.size()) +
                          " bytes");
  }
  std::string text =
      "{'descr': '" + std::string(description(type)) + "', 'fortran_order': False, 'shape': (";
  for (const std::size_t size : shape) text += std::to_string(size) + ", ";
  text += "), }";
  constexpr std::size_t kPrefix = 10, kAlignment = 64;
  text.append(kAlignment - 1 - (kPrefix + text.size()) % kAlignment, ' ');
  text += '\n';
  std::string bytes = "\x93NUMPY";
  bytes += {'\1', '\0', static_cast<char>(text.size() & 255), static_cast<char>(text.size() >> 8)};
  bytes += text;
  return bytes.append(data);
}

template <class T>
std::string encode_npy(std::span<const T> values, const std::vector<std::size_t>& shape) {
  return encode_npy(number_type_of<T>(), shape,
                    {reinterpret_cast<const char*>(values.data()), values.size_bytes()});
}

template <class T>
void write_npy(const std::filesystem::path& path, std::span<const T> values,
               const std::vector<std::size_t>& shape) {
  write_file(path, encode_npy(values, shape));
}

#define ARBOX_INSTANTIATE(T)                                                               \
  template std::vector<T> NpyArray::values<T>() const;                                     \
  template std::string encode_npy<T>(std::span<const T>, const std::vector<std::size_t>&); \
  template void write_npy<T>(const std::filesystem::path&, std::span<const T>,             \
                             const std::vector<std::size_t>&);
ARBOX_INSTANTIATE(float)
ARBOX_INSTANTIATE(double)
ARBOX_INSTANTIATE(std::int32_t)
ARBOX_INSTANTIATE(std::int64_t)
ARBOX_INSTANTIATE(std::uint8_t)
ARBOX_INSTANTIATE(std::uint32_t)
#undef ARBOX_INSTANTIATE

}  // namespace arbox::io
