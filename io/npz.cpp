#include "arbox/io/npz.h"

#include <algorithm>

#include "arbox/base/error.h"
#include "arbox/io/file.h"
#include "arbox/io/internal/parse.h"
#include "arbox/io/internal/text.h"
#include "arbox/io/internal/zip_archive.h"

namespace arbox::io {
namespace {

constexpr std::string_view kSuffix = ".npy";

}  // namespace

struct NpzFile::Archive {
  std::string content;
  std::string name;
  std::uint64_t limit;
  internal::ZipReader zip;
  std::vector<std::string> names = {};
  std::vector<std::size_t> entries = {};

  Archive(std::string bytes, std::string file, std::uint64_t bound)
      : content(std::move(bytes)),
        name(std::move(file)),
        limit(bound),
        zip(content, name, "a npz file") {}
};

NpzFile::~NpzFile() = default;
NpzFile::NpzFile(NpzFile&&) noexcept = default;
NpzFile& NpzFile::operator=(NpzFile&&) noexcept = default;

NpzFile::NpzFile(std::string bytes, std::string name, std::uint64_t limit)
    : archive_(std::make_unique<Archive>(std::move(bytes), std::move(name), limit)) {
  constexpr std::uint64_t kLeastLimit = 64 << 20, kRatio = 256;
  Archive& archive = *archive_;
  if (limit == 0) archive.limit = std::max(kLeastLimit, kRatio * archive.content.size());
  const auto& entries = archive.zip.entries();
  for (std::size_t i = 0; i < entries.size(); ++i) {
    const std::string_view full = entries[i].name;
    if (!full.ends_with(kSuffix)) continue;
    archive.names.emplace_back(full.substr(0, full.size() - kSuffix.size()));
    archive.entries.push_back(i);
  }
}

const std::vector<std::string>& NpzFile::names() const { return archive_->names; }

std::string NpzFile::bytes(std::string_view array) const {
  const Archive& archive = *archive_;
  const auto found = std::find(archive.names.begin(), archive.names.end(), array);
  if (found == archive.names.end()) {
    throw InvalidArgument(archive.name + ": no array " + internal::quoted_text(array) +
                          "; it holds " +
                          (archive.names.empty() ? "none" : internal::listed(archive.names)));
  }
  const std::size_t entry =
      archive.entries[static_cast<std::size_t>(found - archive.names.begin())];
  return archive.zip.read(entry, archive.limit,
                          archive.name + ": array " + internal::quoted_text(array));
}

NpyArray NpzFile::read(std::string_view array) const {
  return parse_npy(bytes(array), archive_->name + ": array " + internal::quoted_text(array));
}

NpzFile open_npz(const std::filesystem::path& path, std::uint64_t limit) {
  return {read_file(path), path.string(), limit};
}

std::string encode_npz(const std::vector<std::pair<std::string, std::string>>& arrays) {
  std::vector<internal::ZipMember> members;
  for (const auto& [name, bytes] : arrays) members.push_back({name + std::string(kSuffix), bytes});
  return internal::encode_zip(members, true, "encode_npz");
}

}  // namespace arbox::io
