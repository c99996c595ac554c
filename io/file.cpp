#include "arbox/io/file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <system_error>

#include "arbox/base/error.h"

namespace arbox::io {
namespace {

[[noreturn]] void fail(const std::filesystem::path& path, const std::string& what) {
  throw IoError(path.string() + ": " + what);
}

/// A file to read from, closed at the end.
class OpenFile {
 public:
  explicit OpenFile(const std::filesystem::path& path)
      : path_(path), descriptor_(::open(path.c_str(), O_RDONLY | O_CLOEXEC)) {
    if (descriptor_ >= 0) return;
    if (errno == ENOENT || errno == ENOTDIR) fail(path, "no such file");
    fail(path, std::string("cannot be opened: ") + std::strerror(errno));
  }
  ~OpenFile() { ::close(descriptor_); }
  OpenFile(const OpenFile&) = delete;
  OpenFile& operator=(const OpenFile&) = delete;

  struct stat status() const {
    struct stat status {};
    if (::fstat(descriptor_, &status) != 0) fail(path_, std::strerror(errno));
    return status;
  }

  /// Up to `most` bytes; fewer only at the end.
  std::size_t read(char* to, std::size_t most) const {
    std::size_t done = 0;
    while (done < most) {
      const ssize_t got = ::read(descriptor_, to + done, most - done);
      if (got < 0 && errno == EINTR) continue;
      if (got < 0) fail(path_, std::string("cannot be read: ") + std::strerror(errno));
      if (got == 0) break;
      done += static_cast<std::size_t>(got);
    }
    return done;
  }

 private:
  const std::filesystem::path& path_;
  int descriptor_;
};

std::string reason_not_written(const std::filesystem::path& path) {
  std::error_code error;
  const std::filesystem::path folder = path.has_parent_path() ? path.parent_path() : ".";
  if (!std::filesystem::exists(folder, error)) {
    return "cannot be written: there is no folder " + folder.string();
  }
  return std::string("cannot be written: ") + std::strerror(errno);
}

/// A pipe, a terminal, /dev/stdout: what has no content to keep and cannot be replaced.
bool is_device(const std::filesystem::path& path) {
  std::error_code error;
  const auto status = std::filesystem::status(path, error);
  return std::filesystem::is_character_file(status) || std::filesystem::is_fifo(status);
}

/// False with errno if not all could be written.
bool write_straight(const std::filesystem::path& path, std::string_view content) {
  errno = 0;
  std::ofstream stream(path, std::ios::binary | std::ios::trunc);
  stream.write(content.data(), static_cast<std::streamsize>(content.size()));
  stream.close();
  return static_cast<bool>(stream);
}

}  // namespace

std::string read_file(const std::filesystem::path& path, std::uint64_t limit) {
  const OpenFile file(path);
  const struct stat status = file.status();
  if (S_ISDIR(status.st_mode)) fail(path, "expected a file, got a directory");
  std::string content;
  if (S_ISREG(status.st_mode)) {
    content.resize(std::min<std::uint64_t>(static_cast<std::uint64_t>(status.st_size), limit));
    if (file.read(content.data(), content.size()) != content.size()) fail(path, "cannot be read");
    return content;
  }
  char buffer[1 << 16];
  while (content.size() < limit) {
    const std::size_t most = std::min<std::uint64_t>(sizeof buffer, limit - content.size());
    const std::size_t got = file.read(buffer, most);
    content.append(buffer, got);
    if (got < most) break;
  }
  return content;
}

void write_file(const std::filesystem::path& path, std::string_view content) {
  if (is_device(path)) {
    if (!write_straight(path, content)) fail(path, reason_not_written(path));
    return;
  }
  std::error_code error, ignored;
  // A link stays; what it leads to is replaced.
  const bool link = std::filesystem::is_symlink(path, error);
  const std::filesystem::path target = link ? std::filesystem::weakly_canonical(path, error) : path;
  std::filesystem::path beside = target;
  beside += ".part" + std::to_string(::getpid());
  if (!write_straight(beside, content)) {
    const std::string reason = reason_not_written(target);
    std::filesystem::remove(beside, ignored);
    fail(path, reason);
  }
  std::filesystem::rename(beside, target, error);
  if (error) {
    std::filesystem::remove(beside, ignored);
    fail(path, "cannot be written: " + error.message());
  }
}

}  // namespace arbox::io
