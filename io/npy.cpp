#include "arbox/io/npy.h"

#include <cmath>
#include <limits>
#include <type_traits>

#include "arbox/base/error.h"
#include "arbox/io/file.h"
#include "arbox/io/internal/load_number.h"

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

// Position in the file of every number in C order, for an array in Fortran order.
class FortranOrder {
 public:
  explicit FortranOrder(const std::vector<std::size_t>& shape)
      : shape_(shape), index_(shape.size()), stride_(shape.size()) {
    std::size_t stride = 1;
    for (std::size_t axis = 0; axis < shape.size(); ++axis) {
      stride_[axis] = stride;
      stride *= shape[axis];
    }
  }

  std::size_t position() const { return position_; }

  void advance() {
    for (std::size_t axis = shape_.size(); axis-- > 0;) {
      position_ += stride_[axis];
      if (++index_[axis] < shape_[axis]) return;
      position_ -= stride_[axis] * shape_[axis];
      index_[axis] = 0;
    }
  }

 private:
  const std::vector<std::size_t>& shape_;
  std::vector<std::size_t> index_, stride_;
  std::size_t position_ = 0;
};

template <class T>
constexpr std::string_view kDescription = "";
template <>
constexpr std::string_view kDescription<float> = "<f4";
template <>
constexpr std::string_view kDescription<double> = "<f8";
template <>
constexpr std::string_view kDescription<std::int32_t> = "<i4";
template <>
constexpr std::string_view kDescription<std::int64_t> = "<i8";
template <>
constexpr std::string_view kDescription<std::uint8_t> = "|u1";
template <>
constexpr std::string_view kDescription<std::uint32_t> = "<u4";

}  // namespace

template <class T>
std::vector<T> NpyArray::values() const {
  const auto* from = reinterpret_cast<const std::byte*>(data_.data());
  std::vector<T> result(size());
  internal::with_type(header_.type, [&](auto stored) {
    using Stored = decltype(stored);
    FortranOrder order(header_.shape);
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

template <class T>
std::string encode_npy(std::span<const T> values, const std::vector<std::size_t>& shape) {
  const std::size_t count = NpyHeader{.shape = shape}.count();
  if (count != values.size()) {
    throw InvalidArgument("encode_npy: the shape holds " + std::to_string(count) +
                          " numbers, got " + std::to_string(values.size()));
  }
  std::string text =
      "{'descr': '" + std::string(kDescription<T>) + "', 'fortran_order': False, 'shape': (";
  for (const std::size_t size : shape) text += std::to_string(size) + ", ";
  text += "), }";
  constexpr std::size_t kPrefix = 10, kAlignment = 64;
  text.append(kAlignment - 1 - (kPrefix + text.size()) % kAlignment, ' ');
  text += '\n';
  std::string bytes = "\x93NUMPY";
  bytes += {'\1', '\0', static_cast<char>(text.size() & 255), static_cast<char>(text.size() >> 8)};
  bytes += text;
  bytes.append(reinterpret_cast<const char*>(values.data()), values.size_bytes());
  return bytes;
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
