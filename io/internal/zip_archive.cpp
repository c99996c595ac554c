#include "arbox/io/internal/zip_archive.h"

#include <zip.h>

#include <algorithm>
#include <utility>

#include "arbox/base/error.h"
#include "arbox/io/internal/parse.h"

namespace arbox::io::internal {
namespace {

struct Discard {
  void operator()(zip_t* archive) const { zip_discard(archive); }
  void operator()(zip_file_t* file) const { zip_fclose(file); }
  void operator()(zip_source_t* source) const { zip_source_free(source); }
};
using Source = std::unique_ptr<zip_source_t, Discard>;
using Zip = std::unique_ptr<zip_t, Discard>;
using File = std::unique_ptr<zip_file_t, Discard>;

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

std::string read_back(zip_source_t* source, const std::string& where) {
  zip_stat_t status;
  std::string result;
  if (zip_source_stat(source, &status) == 0 && zip_source_open(source) == 0) {
    result.resize(status.size);
    const auto got = zip_source_read(source, result.data(), result.size());
    zip_source_close(source);
    if (got == static_cast<zip_int64_t>(result.size())) return result;
  }
  throw IoError(where + ": the archive in memory cannot be read back");
}

}  // namespace

struct ZipReader::Archive {
  Zip zip;
};

ZipReader::~ZipReader() = default;
ZipReader::ZipReader(ZipReader&&) noexcept = default;
ZipReader& ZipReader::operator=(ZipReader&&) noexcept = default;

ZipReader::ZipReader(std::string_view bytes, std::string name, const std::string& what)
    : archive_(std::make_unique<Archive>()) {
  if (bytes.empty()) fail(name, "expected " + what + ", got an empty file");
  ZipError error;
  Source source(zip_source_buffer_create(bytes.data(), bytes.size(), 0, error.get()));
  if (source) archive_->zip = opened(std::move(source), ZIP_RDONLY, error);
  if (!archive_->zip) {
    const bool begun = bytes.starts_with("PK\3\4");
    fail(name,
         "expected " + what + " (zip archive)" +
             (begun ? ", got the beginning of one: the file is truncated or damaged: " : ": ") +
             error.text());
  }
  const auto count = zip_get_num_entries(archive_->zip.get(), 0);
  for (zip_int64_t i = 0; i < count; ++i) {
    zip_stat_t status;
    if (zip_stat_index(archive_->zip.get(), static_cast<zip_uint64_t>(i), 0, &status) != 0 ||
        (status.valid & (ZIP_STAT_NAME | ZIP_STAT_SIZE)) != (ZIP_STAT_NAME | ZIP_STAT_SIZE)) {
      fail(name, "entry " + std::to_string(i) + " of the zip archive has no name or no size");
    }
    entries_.push_back({status.name, status.size});
  }
}

std::string ZipReader::read(std::size_t entry, std::uint64_t limit,
                            const std::string& where) const {
  const File file(zip_fopen_index(archive_->zip.get(), entry, 0));
  if (!file) fail(where, std::string("cannot be read: ") + zip_strerror(archive_->zip.get()));
  const std::uint64_t told = entries_.at(entry).size;
  if (told > limit) {
    fail(where, "decompresses to " + std::to_string(told) + " bytes, more than the limit of " +
                    std::to_string(limit));
  }
  std::string result;
  for (;;) {
    // Grows with what really comes, whatever was told; one byte more shows that all has come.
    constexpr std::uint64_t kLeastPiece = 1 << 18;
    const std::uint64_t held = result.size();
    const std::uint64_t piece =
        held < told ? std::min(told - held, std::max(kLeastPiece, held)) : 1;
    result.resize(held + piece);
    const auto got = zip_fread(file.get(), result.data() + held, piece);
    if (got < 0) fail(where, std::string("is damaged: ") + zip_file_strerror(file.get()));
    result.resize(held + static_cast<std::uint64_t>(got));
    if (got == 0 && result.size() == told) return result;
    if (got == 0 || result.size() > told) {
      fail(where, "is damaged: expected " + std::to_string(told) + " bytes as the archive tells");
    }
  }
}

std::string encode_zip(const std::vector<ZipMember>& members, bool deflate,
                       const std::string& where) {
  ZipError error;
  Source source(zip_source_buffer_create(nullptr, 0, 0, error.get()));
  if (!source) throw IoError(where + ": " + error.text());
  zip_source_keep(source.get());
  const Source kept(source.get());
  Zip zip = opened(std::move(source), ZIP_CREATE | ZIP_TRUNCATE, error);
  if (!zip) throw IoError(where + ": " + error.text());
  const auto require = [&](bool good) {
    if (!good) throw IoError(where + ": " + zip_strerror(zip.get()));
  };
  for (const ZipMember& member : members) {
    Source data(zip_source_buffer(zip.get(), member.content.data(), member.content.size(), 0));
    require(data != nullptr);
    const auto added = zip_file_add(zip.get(), member.name.c_str(), data.get(), ZIP_FL_ENC_UTF_8);
    require(added >= 0);
    static_cast<void>(data.release());
    const auto index = static_cast<zip_uint64_t>(added);
    // A fixed time (1980-01-01, zip's first), so that equal members give equal bytes.
    require(zip_file_set_dostime(zip.get(), index, 0, 0x21, 0) == 0);
    if (!deflate) require(zip_set_file_compression(zip.get(), index, ZIP_CM_STORE, 0) == 0);
  }
  require(zip_close(zip.get()) == 0);
  static_cast<void>(zip.release());
  return members.empty() ? std::string() : read_back(kept.get(), where);
}

}  // namespace arbox::io::internal
