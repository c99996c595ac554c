#include <cstdint>

#include "arbox/io/model_archive.h"
#include "arbox/io/npy.h"

namespace arbox::io {

std::size_t ModelRecord::count() const { return NpyHeader{.shape = shape}.count(); }

template <class T>
std::vector<T> ModelRecord::values() const {
  return parse_npy(encode_npy(type, shape, data), "ModelRecord::values").values<T>();
}

template <class T>
ModelRecord make_record(std::span<const T> values, const std::vector<std::size_t>& shape) {
  const NpyArray array = parse_npy(encode_npy<T>(values, shape), "make_record");
  return {.type = array.header().type, .shape = shape, .data = std::string(array.data())};
}

#define ARBOX_INSTANTIATE(T)                              \
  template std::vector<T> ModelRecord::values<T>() const; \
  template ModelRecord make_record<T>(std::span<const T>, const std::vector<std::size_t>&);
ARBOX_INSTANTIATE(float)
ARBOX_INSTANTIATE(double)
ARBOX_INSTANTIATE(std::int32_t)
ARBOX_INSTANTIATE(std::int64_t)
ARBOX_INSTANTIATE(std::uint8_t)
ARBOX_INSTANTIATE(std::uint32_t)
#undef ARBOX_INSTANTIATE

}  // namespace arbox::io
