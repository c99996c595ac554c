#include "arbox/training/durable_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <string>
#include <system_error>

#include "arbox/base/error.h"

namespace arbox::training {
namespace {

constexpr std::string_view kUnfinished = ".unfinished-";

[[noreturn]] void fail(const std::filesystem::path& path) {
  throw IoError(path.string() + ": cannot be written: " + std::strerror(errno));
}

/// An open file, closed at the end of its scope.
class Descriptor {
 public:
  Descriptor(const std::filesystem::path& path, int flags)
      : path_(path), handle_(::open(path.c_str(), flags | O_CLOEXEC, 0666)) {
    if (handle_ < 0) fail(path_);
  }
  ~Descriptor() { ::close(handle_); }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;

  void write(std::string_view content) const {
    while (!content.empty()) {
      const ssize_t count = ::write(handle_, content.data(), content.size());
      if (count < 0 && errno == EINTR) continue;
      if (count < 0) fail(path_);
      content.remove_prefix(static_cast<std::size_t>(count));
    }
  }
  void sync() const {
    if (::fsync(handle_) != 0) fail(path_);
  }

 private:
  std::filesystem::path path_;
  int handle_;
};

std::filesystem::path folder_of(const std::filesystem::path& path) {
  return path.has_parent_path() ? path.parent_path() : std::filesystem::path(".");
}

}  // namespace

void write_durably(const std::filesystem::path& path, std::string_view content) {
  std::filesystem::path beside = path;
  beside += std::string(kUnfinished) + std::to_string(::getpid());
  std::error_code error;
  try {
    const Descriptor file(beside, O_WRONLY | O_CREAT | O_TRUNC);
    file.write(content);
    file.sync();
    if (::rename(beside.c_str(), path.c_str()) != 0) fail(path);
  } catch (...) {
    std::filesystem::remove(beside, error);
    throw;
  }
  Descriptor(folder_of(path), O_RDONLY | O_DIRECTORY).sync();
}

void remove_unfinished(const std::filesystem::path& folder) {
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(folder, error)) {
    if (entry.path().filename().string().find(kUnfinished) != std::string::npos) {
      std::filesystem::remove(entry.path(), error);
    }
  }
}

}  // namespace arbox::training
