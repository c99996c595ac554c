#pragma once

#include <chrono>
#include <cstdint>
#include <mutex>
#include <string>

namespace arbox::cli {

/// A bar on standard error for work of more than a moment:
///
///     Progress progress("detect", files.size());
///     for (...) { ...; progress.advance(); }
///
/// Draws only on a terminal, at most ten times a second, from half a second on; erases itself at
/// the end of its scope. May be advanced from several threads.
class Progress {
 public:
  /// `descriptor` is where it draws, if that is a terminal.
  Progress(std::string label, std::int64_t total, int descriptor = 2);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  void advance(std::int64_t steps = 1);

 private:
  using Clock = std::chrono::steady_clock;

  void draw(Clock::time_point now);
  void write(const std::string& text) const;

  std::string label_;
  std::int64_t total_;
  std::int64_t done_ = 0;
  int descriptor_;
  bool terminal_;
  bool drawn_ = false;
  Clock::time_point start_ = Clock::now();
  Clock::time_point next_;
  std::mutex mutex_;
};

/// One state of the bar, for example "detect [#####-----] 50/100, 00:12 left".
std::string progress_text(const std::string& label, std::int64_t done, std::int64_t total,
                          double seconds);

}  // namespace arbox::cli
