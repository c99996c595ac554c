#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

/// \file
/// Zip archives in memory: what npz files, models and checkpoints are.

namespace arbox::io::internal {

struct ZipEntry {
  std::string name;
  /// Bytes when unpacked, as the archive's directory tells.
  std::uint64_t size = 0;
};

/// Reads an archive. Nothing is unpacked before it is asked for. Not for several threads at once.
class ZipReader {
 public:
  /// `bytes` must live as long. `what` is what the user expected, such as "a npz file". Throws
  /// FormatError that begins with `name`.
  ZipReader(std::string_view bytes, std::string name, const std::string& what);
  ~ZipReader();
  ZipReader(ZipReader&&) noexcept;
  ZipReader& operator=(ZipReader&&) noexcept;

  const std::vector<ZipEntry>& entries() const { return entries_; }

  /// Unpacks an entry and compares its check sum. `where` begins messages. Throws FormatError for
  /// damage and as soon as there are more than `limit` bytes.
  std::string read(std::size_t entry, std::uint64_t limit, const std::string& where) const;

 private:
  struct Archive;
  std::unique_ptr<Archive> archive_;
  std::vector<ZipEntry> entries_;
};

struct ZipMember {
  std::string name;
  std::string_view content;
};

/// An archive of these members in this order, without times, so that equal members give equal
/// bytes. Throws IoError that names `where`.
std::string encode_zip(const std::vector<ZipMember>& members, bool deflate,
                       const std::string& where);

}  // namespace arbox::io::internal
