#include "arbox/training/tensor_record.h"

#include <ATen/ops/empty.h>

#include <array>
#include <cstring>
#include <utility>

#include "arbox/base/error.h"

namespace arbox::training {
namespace {

constexpr std::array<std::pair<at::ScalarType, io::NumberType>, 9> kTypes = {{
    {at::kBool, io::NumberType::kBool},
    {at::kChar, io::NumberType::kInt8},
    {at::kByte, io::NumberType::kUint8},
    {at::kShort, io::NumberType::kInt16},
    {at::kInt, io::NumberType::kInt32},
    {at::kLong, io::NumberType::kInt64},
    {at::kHalf, io::NumberType::kFloat16},
    {at::kFloat, io::NumberType::kFloat32},
    {at::kDouble, io::NumberType::kFloat64},
}};

}  // namespace

io::ModelRecord to_record(const at::Tensor& tensor) {
  const at::Tensor numbers = tensor.detach().cpu().contiguous();
  for (const auto& [type, number] : kTypes) {
    if (type != numbers.scalar_type()) continue;
    return {number,
            {numbers.sizes().begin(), numbers.sizes().end()},
            {static_cast<const char*>(numbers.data_ptr()), numbers.nbytes()}};
  }
  throw InvalidArgument(std::string("to_record: files have no numbers of type ") +
                        c10::toString(numbers.scalar_type()));
}

at::Tensor to_tensor(const io::ModelRecord& record) {
  const std::vector<std::int64_t> shape(record.shape.begin(), record.shape.end());
  for (const auto& [type, number] : kTypes) {
    if (number != record.type) continue;
    at::Tensor tensor = at::empty(shape, type);
    std::memcpy(tensor.data_ptr(), record.data.data(), tensor.nbytes());
    return tensor;
  }
  throw FormatError("record of type " + std::string(io::name_of(record.type)) +
                    ": tensors have no such type");
}

}  // namespace arbox::training
