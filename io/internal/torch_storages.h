#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "arbox/io/internal/zip_archive.h"
#include "arbox/io/torch_checkpoint.h"

namespace arbox::io {

/// Where the numbers of a checkpoint's tensors are.
struct TorchCheckpoint::Storages {
  virtual ~Storages() = default;
  /// The bytes of a storage by its key. Throws FormatError that begins with `place` if there is no
  /// such storage.
  virtual std::string_view bytes(const std::string& key, const std::string& place) = 0;

  std::size_t file_size = 0;
};

namespace internal {

/// A number of PyTorch.
struct TorchNumber {
  NumberType type = NumberType::kFloat32;
  /// The upper half of a float32; `type` is kFloat16 for its size.
  bool bfloat16 = false;

  std::size_t bytes() const { return size_of(type); }
};

/// What a persistent id names.
struct TorchStorage {
  std::string key;
  /// Nothing for a storage of bytes of any type.
  std::optional<TorchNumber> number;
};

/// Throws FormatError for what is no id of a storage.
TorchStorage read_torch_storage(const PickleValue& persistent);

/// The number that a type such as torch.float32 or torch.FloatStorage names; nothing for others.
std::optional<TorchNumber> torch_number(std::string_view name);

/// The archives of PyTorch since 1.6.
TorchCheckpoint parse_torch_zip(std::shared_ptr<const std::string> bytes, const std::string& name);

/// The streams of pickles before.
TorchCheckpoint parse_torch_stream(std::shared_ptr<const std::string> bytes,
                                   const std::string& name);

}  // namespace internal
}  // namespace arbox::io
