#include "arbox/cli/scan_journal.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>
#include <utility>

#include "arbox/base/error.h"
#include "arbox/cli/command_line.h"

namespace arbox::cli {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::string_view kHead = "{\"file\": ";
// In a JSON text a quotation mark within a string has a backslash before it: this ends the object.
constexpr std::string_view kHeadEnd = "}, \"";

// Room for this many files is taken at the start, so that memory does not grow with each.
constexpr std::size_t kUsualFiles = 1 << 16;

std::string json_text(const std::string& text) {
  return Json(text).dump(-1, ' ', false, Json::error_handler_t::replace);
}

std::uint64_t hash_of(const std::string& text) { return std::hash<std::string>()(text); }

/// As the name stands in the journal, where bytes that are not UTF-8 are replaced.
std::uint64_t hash_of_name(const std::string& name) { return hash_of(json_text(name)); }

std::uint64_t hash_of(const FileState& state) {
  return hash_of(std::to_string(state.inode) + ' ' + std::to_string(state.size) + ' ' +
                 std::to_string(state.modified));
}

/// One line as text: the file, the error if there is one, and all of the detections' JSON.
std::string line_of(const std::string& name, const FileState& state, const io::ScanDetections& scan,
                    const std::string& error) {
  std::string line = std::string(kHead) + "{\"name\": " + json_text(name) +
                     ", \"inode\": " + std::to_string(state.inode) +
                     ", \"size\": " + std::to_string(state.size) +
                     ", \"modified\": " + std::to_string(state.modified) + "}, ";
  if (!error.empty()) line += "\"error\": " + json_text(error) + ", ";
  return line + io::format_detections_json(scan).substr(1) + "\n";
}

}  // namespace

int open_to_append(const std::filesystem::path& path) {
  const int file = ::open(path.c_str(), O_RDWR | O_CREAT | O_APPEND | O_CLOEXEC, 0666);
  if (file < 0) throw IoError(path.string() + ": cannot be written: " + std::strerror(errno));
  return file;
}

void append(const Descriptor& file, const std::filesystem::path& path, std::string_view text) {
  while (!text.empty()) {
    const ssize_t count = ::write(file.get(), text.data(), text.size());
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) throw IoError(path.string() + ": cannot be written: " + std::strerror(errno));
    text.remove_prefix(static_cast<std::size_t>(count));
  }
}

ScanJournal::ScanJournal(std::filesystem::path path)
    : path_(std::move(path)), file_(open_to_append(path_)) {
  done_.reserve(kUsualFiles);
  if (::flock(file_.get(), LOCK_EX | LOCK_NB) != 0) {
    throw NotAvailable(path_.string() + ": another 'arbox watch' writes to it");
  }
  read_lines();
}

void ScanJournal::read_lines() {
  std::ifstream stream(path_, std::ios::binary);
  std::string line;
  std::uint64_t whole = 0;
  for (std::size_t number = 1; std::getline(stream, line) && !stream.eof(); ++number) {
    whole += line.size() + 1;
    const std::size_t end = line.find(kHeadEnd);
    try {
      if (!line.starts_with(kHead) || end == std::string::npos) throw FormatError("");
      const auto file = nlohmann::json::parse(line.begin() + kHead.size(), line.begin() + end + 1);
      remember(hash_of_name(file.at("name").get<std::string>()),
               hash_of(FileState{.inode = file.at("inode"),
                                 .size = file.at("size"),
                                 .modified = file.at("modified")}));
    } catch (const std::exception&) {
      throw FormatError(path_.string() + ":" + std::to_string(number) +
                        ": expected a line that 'arbox watch' wrote; give another --output");
    }
  }
  stream.close();
  std::error_code error;
  if (std::filesystem::file_size(path_, error) > whole &&
      ::ftruncate(file_.get(), static_cast<off_t>(whole)) != 0) {
    throw IoError(path_.string() + ": cannot be cut: " + std::strerror(errno));
  }
}

std::vector<ScanJournal::Done>::iterator ScanJournal::find(std::uint64_t name) {
  return std::lower_bound(
      done_.begin(), done_.end(), name,
      [](const Done& done, std::uint64_t wanted) { return done.name < wanted; });
}

void ScanJournal::remember(std::uint64_t name, std::uint64_t state) {
  const auto place = find(name);
  if (place != done_.end() && place->name == name) {
    place->state = state;
  } else {
    done_.insert(place, {name, state});
  }
}

bool ScanJournal::has(const std::string& name, const FileState& state) {
  const std::uint64_t hash = hash_of_name(name);
  const auto place = find(hash);
  return place != done_.end() && place->name == hash && place->state == hash_of(state);
}

void ScanJournal::add(const std::string& name, const FileState& state,
                      const io::ScanDetections& scan, const std::string& error) {
  append(file_, path_, line_of(name, state, scan, fold_lines(error)));
  remember(hash_of_name(name), hash_of(state));
}

void ScanJournal::forget(const std::string& name) {
  const std::uint64_t hash = hash_of_name(name);
  const auto place = find(hash);
  if (place != done_.end() && place->name == hash) done_.erase(place);
}

void ScanJournal::keep_only(const std::vector<std::string>& names) {
  std::vector<std::uint64_t> wanted;
  for (const std::string& name : names) wanted.push_back(hash_of_name(name));
  std::sort(wanted.begin(), wanted.end());
  std::erase_if(done_, [&](const Done& done) {
    return !std::binary_search(wanted.begin(), wanted.end(), done.name);
  });
}

}  // namespace arbox::cli
