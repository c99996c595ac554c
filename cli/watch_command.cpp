#include <spdlog/fmt/chrono.h>
#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <deque>
#include <iostream>
#include <memory>
#include <tuple>

#include "arbox/cli/command_line.h"
#include "arbox/cli/commands.h"
#include "arbox/cli/detector_flags.h"
#include "arbox/cli/latency.h"
#include "arbox/cli/scan_journal.h"

namespace arbox::cli {
namespace {

namespace fs = std::filesystem;

struct WatchFlags : DetectorFlags {
  fs::path folder, output;
  /// 0 means without end.
  std::uint64_t scans = 0;
};

constexpr std::uint64_t kScansBetweenSummaries = 1000;

double now() {
  return std::chrono::duration<double, std::milli>(
             std::chrono::system_clock::now().time_since_epoch())
      .count();
}

/// Lines for people, each written at once.
class WatchLog {
 public:
  explicit WatchLog(fs::path path) : path_(std::move(path)), file_(open_to_append(path_)) {}
  void line(const std::string& text) const {
    const auto time =
        std::chrono::floor<std::chrono::milliseconds>(std::chrono::system_clock::now());
    append(file_, path_,
           fmt::format("{:%Y-%m-%dT%H:%M:}{:%S}Z {}\n", time, time.time_since_epoch(), text));
  }

 private:
  fs::path path_;
  Descriptor file_;
};

fs::path made_folder(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) throw IoError(folder.string() + ": cannot be made: " + error.message());
  return folder;
}

class Watcher {
 public:
  explicit Watcher(const WatchFlags& flags)
      : flags_(flags),
        detector_(make_detector(flags)),
        watch_(flags.folder),
        output_(made_folder(flags.output.empty() ? flags.folder : flags.output)),
        journal_(output_ / "detections.jsonl"),
        log_(output_ / "watch.log") {
    list_folder();
    log_.line("watching " + flags_.folder.string() + ", " + std::to_string(waiting_.size()) +
              " scans are waiting");
  }

  void run() {
    while (!done()) {
      const FolderEvents events = watch_.events(waiting_.empty());
      for (const std::string& name : events.left) journal_.forget(name);
      for (const std::string& name : events.arrived) {
        if (is_scan(name)) waiting_.push_back(name);
      }
      if (events.overflow) list_folder();
      if (events.stop) break;
      if (waiting_.empty()) continue;
      const std::string name = std::move(waiting_.front());
      waiting_.pop_front();
      take(name);
    }
    finish();
  }

 private:
  bool done() const { return flags_.scans > 0 && latency_.count() >= flags_.scans; }

  bool is_scan(const std::string& name) const {
    if (name.starts_with('.')) return false;
    if (!flags_.read.format.empty()) return name != "detections.jsonl" && name != "watch.log";
    return io::format_of_extension(name).has_value() && !name.ends_with(".txt");
  }

  /// What is there already, in order of its coming. Files that are still written come later.
  void list_folder() {
    std::vector<std::tuple<std::int64_t, std::string>> found;
    std::vector<std::string> names;
    std::error_code error;
    for (const auto& entry : fs::directory_iterator(flags_.folder, error)) {
      const std::string name = entry.path().filename().string();
      FileState state;
      if (!is_scan(name) || !find_file_state(entry.path(), state)) continue;
      names.push_back(name);
      if (!journal_.has(name, state) && !is_being_written(entry.path())) {
        found.emplace_back(state.changed, name);
      }
    }
    if (error) throw IoError(flags_.folder.string() + ": cannot be listed: " + error.message());
    journal_.keep_only(names);
    std::sort(found.begin(), found.end());
    for (auto& [time, name] : found) waiting_.push_back(std::move(name));
  }

  void take(const std::string& name) {
    const fs::path path = flags_.folder / name;
    FileState state;
    if (!find_file_state(path, state)) {
      spdlog::warn("{}: is gone before it was read", path.string());
      log_.line(fold_lines(name) + ": is gone before it was read");
      return;
    }
    if (journal_.has(name, state)) return;
    try {
      detect(name, path, state);
    } catch (const Error& error) {
      FileState present;
      // Its writer went on: it comes again.
      if (!find_file_state(path, present) || present.modified != state.modified) return;
      journal_.add(name, state, {.source = path.string()}, error.what());
      ++skipped_;
      latency_.add(latency_of(state));
      spdlog::error("{}", fold_lines(error.what()));
      log_.line(fold_lines(name) + ": skipped: " + fold_lines(error.what()));
    }
  }

  void detect(const std::string& name, const fs::path& path, const FileState& state) {
    const double start = now();
    const io::PointCloudFile file = io::read_point_cloud(path, flags_.read);
    const double read = now();
    detectors::DetectionResult result = detector_->detect(file.points.view(), flags_.request);
    const double found = now();
    const std::size_t count = result.detections.size();
    const io::ScanDetections scan{.source = path.string(),
                                  .detections = std::move(result.detections)};
    journal_.add(name, state, scan);
    const double latency = latency_of(state);
    latency_.add(latency);
    log_.line(
        fmt::format("{}: {} detections in {} points, latency {:.1f} ms (waited {:.1f}, read "
                    "{:.1f}, detected {:.1f}, written {:.1f})",
                    fold_lines(name), count, file.points.size(), latency,
                    std::max(0.0, start - 1e-6 * static_cast<double>(state.changed)), read - start,
                    found - read, now() - found));
    if (latency_.count() % kScansBetweenSummaries == 0) log_.line(summary());
  }

  /// From the file's coming into place until its result is written, milliseconds.
  static double latency_of(const FileState& state) {
    return std::max(0.0, now() - 1e-6 * static_cast<double>(state.changed));
  }

  std::string summary() const {
    return fmt::format("{} scans, {} skipped, {}", latency_.count(), skipped_, latency_.text());
  }

  void finish() const {
    log_.line("stopped: " + summary());
    std::cout << summary() << '\n';
  }

  const WatchFlags& flags_;
  std::unique_ptr<detectors::Detector> detector_;
  FolderWatch watch_;
  fs::path output_;
  ScanJournal journal_;
  WatchLog log_;
  std::deque<std::string> waiting_;
  LatencyCount latency_;
  std::uint64_t skipped_ = 0;
};

}  // namespace

void add_watch(CLI::App& app) {
  const auto flags = std::make_shared<WatchFlags>();
  CLI::App* command =
      app.add_subcommand("watch", "Find the objects in each scan that comes into a folder");
  command
      ->add_option("folder", flags->folder,
                   "Folder where scans are written, or renamed into when they are whole")
      ->type_name("DIR")
      ->required();
  command
      ->add_option("--output", flags->output,
                   "Folder of detections.jsonl and watch.log, which grow (default: DIR itself)")
      ->type_name("DIR");
  command->add_option("--scans", flags->scans, "Stop after this many scans (default: never)")
      ->type_name("N")
      ->check(CLI::PositiveNumber.description(""));
  add_detector_flags(*command, *flags);
  command->callback([flags] { Watcher(*flags).run(); });
  add_examples(
      *command,
      {{"arbox watch incoming --output results", "until Ctrl+C; then go on where it ended"},
       {"arbox watch incoming --scans 100 --quantile 0.1", "the next hundred scans"}});
}

}  // namespace arbox::cli
