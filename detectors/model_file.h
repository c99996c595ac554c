#pragma once

#include <ATen/core/Tensor.h>

#include <map>
#include <string>

#include "arbox/io/model_archive.h"

namespace torch::nn {
class Module;
}

/// \file
/// The tensors of a network and the records of a model archive (io/model_archive.h).

namespace arbox::detectors {

using ModelRecords = std::map<std::string, io::ModelRecord>;

/// The numbers of a tensor, bit by bit. Throws InvalidArgument for a type that files do not have
/// (bfloat16, complex, quantised).
io::ModelRecord to_record(const at::Tensor& tensor);

/// A tensor with its own memory, on the CPU. Throws FormatError, beginning with `name`, for uint16,
/// uint32 and uint64, which tensors do not have, and for data that do not fit the shape.
at::Tensor to_tensor(const io::ModelRecord& record, const std::string& name);

/// How many bits of the weights a file keeps.
enum class WeightPrecision {
  /// All.
  kFull,
  /// Parameters of two and more axes as float16, half the size; biases, norms and statistics in
  /// full, and parameters with a number that float16 cannot hold.
  kHalf
};

/// Parameters and buffers of a module by name.
ModelRecords records_of(const torch::nn::Module& module,
                        WeightPrecision precision = WeightPrecision::kFull);

/// Copies records into a module's parameters and buffers, in its own types. Nothing is copied
/// unless all fit: FormatError, beginning with `source`, lists every name that only one side has,
/// every shape that differs, whole numbers for fractions and the other way round, and records with
/// a number that is not finite.
void load_records(torch::nn::Module& module, const ModelRecords& records,
                  const std::string& source);

}  // namespace arbox::detectors
