#include "arbox/detectors/model_file.h"

#include <ATen/core/ivalue.h>  // before nn headers: clang cannot parse them otherwise
#include <ATen/ops/empty.h>
#include <ATen/ops/isfinite.h>
#include <torch/nn/module.h>

#include <array>
#include <cstring>
#include <utility>
#include <vector>

#include "arbox/base/error.h"
#include "arbox/base/names.h"
#include "arbox/heads/parameters.h"

namespace arbox::detectors {
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

at::Tensor halved(const at::Tensor& tensor) {
  if (tensor.dim() < 2 || !tensor.is_floating_point()) return tensor;
  const at::Tensor half = tensor.to(at::kHalf);
  return at::isfinite(half).all().item<bool>() ? half : tensor;
}

}  // namespace

io::ModelRecord to_record(const at::Tensor& tensor) {
  const at::Tensor numbers = tensor.detach().to(at::kCPU).contiguous();
  for (const auto& [type, number] : kTypes) {
    if (type != numbers.scalar_type()) continue;
    return {.type = number,
            .shape = {numbers.sizes().begin(), numbers.sizes().end()},
            .data = {static_cast<const char*>(numbers.data_ptr()), numbers.nbytes()}};
  }
  throw InvalidArgument(std::string("to_record: files have no numbers of type ") +
                        c10::toString(numbers.scalar_type()));
}

at::Tensor to_tensor(const io::ModelRecord& record, const std::string& name) {
  if (record.data.size() % size_of(record.type) != 0 ||
      record.count() != record.data.size() / size_of(record.type)) {
    throw FormatError(name + ": expected " + std::to_string(record.count()) + " numbers of " +
                      std::string(name_of(record.type)) + ", got " +
                      std::to_string(record.data.size()) + " bytes");
  }
  for (const auto& [type, number] : kTypes) {
    if (number != record.type) continue;
    at::Tensor tensor =
        at::empty(std::vector<std::int64_t>(record.shape.begin(), record.shape.end()), type);
    if (!record.data.empty()) {
      std::memcpy(tensor.data_ptr(), record.data.data(), record.data.size());
    }
    return tensor;
  }
  throw FormatError(name + ": tensors have no numbers of type " +
                    std::string(name_of(record.type)));
}

ModelRecords records_of(const torch::nn::Module& module, WeightPrecision precision) {
  ModelRecords records;
  for (const auto& one : module.named_parameters()) {
    const at::Tensor tensor = one.value().detach();
    records[one.key()] = to_record(precision == WeightPrecision::kHalf ? halved(tensor) : tensor);
  }
  for (const auto& one : module.named_buffers()) records[one.key()] = to_record(one.value());
  return records;
}

void load_records(torch::nn::Module& module, const ModelRecords& records,
                  const std::string& source) {
  heads::NamedTensors tensors;
  for (const auto& [name, record] : records) {
    tensors[name] = to_tensor(record, source + ": record '" + name + "'");
  }
  heads::load_parameters(module, tensors, source);
}

}  // namespace arbox::detectors
