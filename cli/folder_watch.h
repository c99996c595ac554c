#pragma once

#include <csignal>
#include <filesystem>
#include <string>
#include <vector>

namespace arbox::cli {

/// A descriptor that is closed at the end of its scope.
class Descriptor {
 public:
  explicit Descriptor(int number = -1) : number_(number) {}
  ~Descriptor();
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  int get() const { return number_; }

 private:
  int number_;
};

/// What happened in a folder since the last time it was asked.
struct FolderEvents {
  /// Names of files that were closed after writing or renamed into the folder, in that order.
  std::vector<std::string> arrived;
  /// Names of files that were removed or renamed out of it.
  std::vector<std::string> left;
  /// The system lost events: only a listing of the folder tells what is there.
  bool overflow = false;
  /// SIGINT or SIGTERM came.
  bool stop = false;
};

/// Watches one folder (inotify), and from then on takes SIGINT and SIGTERM for requests to stop.
class FolderWatch {
 public:
  /// Throws IoError that names the folder.
  explicit FolderWatch(std::filesystem::path folder);

  /// Waits for events if `block`, else tells what is there. Throws IoError when the folder is
  /// removed, moved or unmounted.
  FolderEvents events(bool block);

 private:
  void read_events(FolderEvents& events);

  std::filesystem::path folder_;
  Descriptor notify_, signals_;
};

/// Where a file stands: what tells it from another one of the same name, and when it came.
struct FileState {
  std::uint64_t inode = 0, size = 0;
  /// Last change of the content, nanoseconds since 1970.
  std::int64_t modified = 0;
  /// Last change of content, name or rights, nanoseconds since 1970: when the file came into place.
  std::int64_t changed = 0;
};

/// False if there is no such regular file.
bool find_file_state(const std::filesystem::path& path, FileState& state);

/// True if some program has the file open for writing. False where the system does not tell (files
/// of other users, network file systems).
bool is_being_written(const std::filesystem::path& path);

}  // namespace arbox::cli
