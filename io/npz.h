#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "arbox/io/npy.h"

namespace arbox::io {

/// An archive of NumPy arrays (.npz: a zip file of .npy files), read from memory.
///
/// Safe against zip bombs: an array is decompressed only when it is asked for, piece by piece, and
/// refused as soon as it is larger than `limit`. Not for use by several threads at once.
class NpzFile {
 public:
  /// `bytes` is the content of the archive. `limit` bounds the bytes of one decompressed array; 0
  /// means 64 MiB or 256 times the archive, whichever is more. Throws FormatError that names
  /// `name`.
  NpzFile(std::string bytes, std::string name, std::uint64_t limit = 0);
  ~NpzFile();
  NpzFile(NpzFile&&) noexcept;
  NpzFile& operator=(NpzFile&&) noexcept;

  /// Names of the arrays in the archive's order, without the ".npy".
  const std::vector<std::string>& names() const;

  /// The .npy bytes of an array. Throws InvalidArgument for an unknown name (the message lists the
  /// known ones), FormatError for damage.
  std::string bytes(std::string_view array) const;

  /// The array of that name. Throws like bytes().
  NpyArray read(std::string_view array) const;

 private:
  struct Archive;
  std::unique_ptr<Archive> archive_;
};

/// Throws IoError, FormatError.
NpzFile open_npz(const std::filesystem::path& path, std::uint64_t limit = 0);

/// The bytes of an archive (deflated) of arrays given as name and encode_npy() bytes.
std::string encode_npz(const std::vector<std::pair<std::string, std::string>>& arrays);

}  // namespace arbox::io
