#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "arbox/cli/folder_watch.h"
#include "arbox/io/detection_json.h"

namespace arbox::cli {

/// The results of `arbox watch`, which are its journal too: one line of JSON for each scan,
/// appended with one write, tells both what was found and which file it was. A process that is
/// killed leaves whole lines and at most the beginning of one, which the next process takes away.
/// So each scan is in there once: results and memory of them cannot disagree.
class ScanJournal {
 public:
  /// Opens or makes the file and reads which scans it has. Throws IoError, FormatError for a line
  /// that this class did not write, and NotAvailable if another process writes to the file.
  explicit ScanJournal(std::filesystem::path path);

  /// Whether this very file is done: name, inode, size and time of its content.
  bool has(const std::string& name, const FileState& state);
  /// Appends the line of a scan; `error` tells why it has no detections. Throws IoError.
  void add(const std::string& name, const FileState& state, const io::ScanDetections& scan,
           const std::string& error = "");
  /// Files that are not in the folder any more need not be remembered.
  void forget(const std::string& name);
  void keep_only(const std::vector<std::string>& names);

 private:
  // Hashes: 16 bytes a file, however long its name.
  struct Done {
    std::uint64_t name = 0, state = 0;
  };

  void read_lines();
  std::vector<Done>::iterator find(std::uint64_t name);
  void remember(std::uint64_t name, std::uint64_t state);

  std::filesystem::path path_;
  Descriptor file_;
  // By rising hash of the name.
  std::vector<Done> done_;
};

/// Appends text to a descriptor. Throws IoError that begins with `path`.
void append(const Descriptor& file, const std::filesystem::path& path, std::string_view text);

/// Opens a file to append to, made if need be. Throws IoError.
int open_to_append(const std::filesystem::path& path);

}  // namespace arbox::cli
