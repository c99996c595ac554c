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
  std::filesystem::path beside = path;
  beside += ".part" + std::to_string(::getpid());
  {
    std::ofstream stream(beside, std::ios::binary | std::ios::trunc);
    stream.write(content.data(), static_cast<std::streamsize>(content.size()));
    stream.close();
    if (!stream) {
      std::error_code ignored;
      std::filesystem::remove(beside, ignored);
      fail(path, "cannot be written");
    }
  }
  std::error_code error;
  std::filesystem::rename(beside, path, error);
  if (error) {
    std::error_code ignored;
    std::filesystem::remove(beside, ignored);
    fail(path, "cannot be written: " + error.message());
  }
}

}  // namespace arbox::io
