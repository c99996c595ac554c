#include "arbox/io/npz.h"

#include <zip.h>

#include <algorithm>

#include "arbox/base/error.h"
#include "arbox/io/file.h"
#include "arbox/io/internal/parse.h"
#include "arbox/io/internal/text.h"

namespace arbox::io {
namespace {

using internal::fail;

constexpr std::string_view kSuffix = ".npy";

struct Discard {
  void operator()(zip_t* archive) const { zip_discard(archive); }
  void operator()(zip_file_t* file) const { zip_fclose(file); }
  void operator()(zip_source_t* source) const { zip_source_free(source); }
};
using Source = std::unique_ptr<zip_source_t, Discard>;
using Zip = std::unique_ptr<zip_t, Discard>;

class ZipError {
 public:
  ZipError() { zip_error_init(&error_); }
  ~ZipError() { zip_error_fini(&error_); }
  ZipError(const ZipError&) = delete;
  ZipError& operator=(const ZipError&) = delete;
  zip_error_t* get() { return &error_; }
  std::string text() { return zip_error_strerror(&error_); }

 private:
  zip_error_t error_;
};

Zip opened(Source source, int flags, ZipError& error) {
  Zip zip(zip_open_from_source(source.get(), flags, error.get()));
  if (zip) static_cast<void>(source.release());  // The archive owns it now.
  return zip;
}

}  // namespace

struct NpzFile::Archive {
  std::string content;
  std::string name;
  std::uint64_t limit = 0;
  Zip zip;
  std::vector<std::string> names;
  std::vector<std::uint64_t> indices;
};

NpzFile::~NpzFile() = default;
NpzFile::NpzFile(NpzFile&&) noexcept = default;
NpzFile& NpzFile::operator=(NpzFile&&) noexcept = default;

NpzFile::NpzFile(std::string bytes, std::string name, std::uint64_t limit)
    : archive_(std::make_unique<Archive>()) {
  constexpr std::uint64_t kLeastLimit = 64 << 20, kRatio = 256;
  Archive& archive = *archive_;
  archive.content = std::move(bytes);
  archive.name = std::move(name);
  archive.limit = limit > 0 ? limit : std::max(kLeastLimit, kRatio * archive.content.size());
  if (archive.content.empty()) fail(archive.name, "expected a npz file, got an empty file");
  ZipError error;
  Source source(
      zip_source_buffer_create(archive.content.data(), archive.content.size(), 0, error.get()));
  if (source) archive.zip = opened(std::move(source), ZIP_RDONLY, error);
  if (!archive.zip) fail(archive.name, "expected a npz file (zip archive): " + error.text());
  const auto entries = zip_get_num_entries(archive.zip.get(), 0);
  for (zip_int64_t i = 0; i < entries; ++i) {
    const char* entry = zip_get_name(archive.zip.get(), static_cast<zip_uint64_t>(i), 0);
    if (entry == nullptr || !std::string_view(entry).ends_with(kSuffix)) continue;
    const std::string_view full = entry;
    archive.names.emplace_back(full.substr(0, full.size() - kSuffix.size()));
    archive.indices.push_back(static_cast<std::uint64_t>(i));
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
  const std::string where = archive.name + ": array " + internal::quoted_text(array);
  const std::uint64_t index =
      archive.indices[static_cast<std::size_t>(found - archive.names.begin())];
  const std::unique_ptr<zip_file_t, Discard> file(zip_fopen_index(archive.zip.get(), index, 0));
  if (!file) fail(where, std::string("cannot be read: ") + zip_strerror(archive.zip.get()));
  std::string result;
  constexpr std::size_t kPiece = 1 << 18;
  for (;;) {
    const std::size_t held = result.size();
    if (held > archive.limit) {
      fail(where, "decompresses to more than the limit of " + std::to_string(archive.limit) +
                      " bytes (an archive of " + std::to_string(archive.content.size()) +
                      " bytes)");
    }
    result.resize(held + kPiece);
    const auto got = zip_fread(file.get(), result.data() + held, kPiece);
    if (got < 0) fail(where, std::string("is damaged: ") + zip_file_strerror(file.get()));
    result.resize(held + static_cast<std::size_t>(got));
    if (got == 0) return result;
  }
}

NpyArray NpzFile::read(std::string_view array) const {
  return parse_npy(bytes(array), archive_->name + ": array " + internal::quoted_text(array));
}

NpzFile open_npz(const std::filesystem::path& path, std::uint64_t limit) {
  return {read_file(path), path.string(), limit};
}

std::string encode_npz(const std::vector<std::pair<std::string, std::string>>& arrays) {
  ZipError error;
  Source source(zip_source_buffer_create(nullptr, 0, 0, error.get()));
  if (!source) throw IoError("encode_npz: " + error.text());
  zip_source_keep(source.get());
  const Source kept(source.get());
  Zip zip = opened(std::move(source), ZIP_CREATE | ZIP_TRUNCATE, error);
  if (!zip) throw IoError("encode_npz: " + error.text());
  const auto require = [&](bool good) {
    if (!good) throw IoError(std::string("encode_npz: ") + zip_strerror(zip.get()));
  };
  for (const auto& [name, bytes] : arrays) {
    Source data(zip_source_buffer(zip.get(), bytes.data(), bytes.size(), 0));
    require(data != nullptr);
    const auto index = zip_file_add(zip.get(), (name + std::string(kSuffix)).c_str(), data.get(),
                                    ZIP_FL_ENC_UTF_8);
    require(index >= 0);
    static_cast<void>(data.release());
    // A fixed time (1980-01-01, zip's first), so that equal arrays give equal bytes.
    require(zip_file_set_dostime(zip.get(), static_cast<zip_uint64_t>(index), 0, 0x21, 0) == 0);
  }
  require(zip_close(zip.get()) == 0);
  static_cast<void>(zip.release());
  std::string result;
  if (arrays.empty()) return result;
  zip_stat_t status;
  if (zip_source_stat(kept.get(), &status) != 0 || zip_source_open(kept.get()) != 0) {
    throw IoError("encode_npz: the archive in memory cannot be read back");
  }
  result.resize(status.size);
  const auto got = zip_source_read(kept.get(), result.data(), result.size());
  zip_source_close(kept.get());
  if (got != static_cast<zip_int64_t>(result.size())) {
    throw IoError("encode_npz: the archive in memory cannot be read back");
  }
  return result;
}

}  // namespace arbox::io
