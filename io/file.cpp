#include "arbox/io/file.h"

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
  std::error_code error;
  const auto status = std::filesystem::status(path, error);
  if (!std::filesystem::exists(status)) fail(path, "no such file");
  if (std::filesystem::is_directory(status)) fail(path, "expected a file, got a directory");
  std::ifstream stream(path, std::ios::binary);
  if (!stream) fail(path, std::string("cannot be opened: ") + std::strerror(errno));
  std::string content;
  if (std::filesystem::is_regular_file(status)) {
    content.resize(std::min<std::uint64_t>(std::filesystem::file_size(path), limit));
    stream.read(content.data(), static_cast<std::streamsize>(content.size()));
    if (static_cast<std::size_t>(stream.gcount()) != content.size()) fail(path, "cannot be read");
    return content;
  }
  char buffer[1 << 16];
  while (content.size() < limit &&
         (stream.read(buffer, static_cast<std::streamsize>(
                                  std::min<std::uint64_t>(sizeof buffer, limit - content.size()))),
          stream.gcount() > 0)) {
    content.append(buffer, static_cast<std::size_t>(stream.gcount()));
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
