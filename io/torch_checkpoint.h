#pragma once

#include <cstddef>
#include <filesystem>
#include <map>
#include <memory>
#include <string>

#include "arbox/io/model_archive.h"
#include "arbox/io/pickle.h"

/// \file
/// Files that PyTorch's torch.save writes (.pth, .pt): zip archives (since 1.6) and the older
/// streams of pickles. Read as data: nothing is imported or called (io/pickle.h), so that files of
/// unknown origin can be looked at.
///
///     const auto checkpoint = io::read_torch_checkpoint("pv_rcnn_8369.pth");
///     const auto weights = checkpoint.tensors(checkpoint.value().at("model_state"));

namespace arbox::io {

/// True for a tensor or parameter in a checkpoint.
bool is_torch_tensor(const PickleValue& value);

/// A checkpoint in memory. Not for several threads at once.
class TorchCheckpoint {
 public:
  /// What was saved: a dictionary as a rule.
  const PickleValue& value() const;

  /// A tensor or parameter as a record in C order, whatever its strides; bfloat16 becomes float32,
  /// exactly. Throws FormatError for other values, for numbers beyond the end of their storage, for
  /// types that records do not have (complex, quantised), and for tensors larger than the file (of
  /// numbers repeated by a stride of 0).
  ModelRecord tensor(const PickleValue& value) const;

  /// The tensors of a dictionary by their keys; other values are left out. Throws as tensor(), and
  /// FormatError if together they are more than four times as large as the file.
  std::map<std::string, ModelRecord> tensors(const PickleValue& dictionary) const;

  struct Storages;
  TorchCheckpoint(PickleValue value, std::shared_ptr<Storages> storages);

 private:
  PickleValue value_;
  std::shared_ptr<Storages> storages_;
};

/// `bytes` is the content of a file; `name` begins messages. Throws FormatError for what torch.save
/// did not write or did not finish, for TorchScript modules and for files of PyTorch before 0.1.10.
TorchCheckpoint parse_torch_checkpoint(std::string bytes, const std::string& name);

/// Throws IoError, FormatError.
TorchCheckpoint read_torch_checkpoint(const std::filesystem::path& path);

}  // namespace arbox::io
