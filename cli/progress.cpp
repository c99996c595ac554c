#include "arbox/cli/progress.h"

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

namespace arbox::cli {

Progress::Progress(std::string label, std::int64_t total, int descriptor)
    : label_(std::move(label)),
      total_(total),
      descriptor_(descriptor),
      terminal_(::isatty(descriptor) == 1),
      next_(start_ + std::chrono::milliseconds(500)) {}

Progress::~Progress() {
  if (drawn_) write("\r\x1b[K");
}

void Progress::advance(std::int64_t steps) {
  if (!terminal_) return;
  const std::scoped_lock lock(mutex_);
  done_ += steps;
  const auto now = Clock::now();
  if (now >= next_) draw(now);
}

void Progress::draw(Clock::time_point now) {
  next_ = now + std::chrono::milliseconds(100);
  drawn_ = true;
  const double seconds = std::chrono::duration<double>(now - start_).count();
  write("\r\x1b[K" + progress_text(label_, done_, total_, seconds));
}

void Progress::write(const std::string& text) const {
  // A terminal that went away is no reason to stop the work.
  [[maybe_unused]] const auto written = ::write(descriptor_, text.data(), text.size());
}

std::string progress_text(const std::string& label, std::int64_t done, std::int64_t total,
                          double seconds) {
  constexpr int kWidth = 30;
  const double part =
      total > 0 ? std::clamp(static_cast<double>(done) / static_cast<double>(total), 0.0, 1.0) : 1;
  const int filled = static_cast<int>(part * kWidth);
  std::string text = label + " [" + std::string(filled, '#') + std::string(kWidth - filled, '-') +
                     "] " + std::to_string(done) + "/" + std::to_string(total);
  if (done > 0 && done < total) {
    const auto left = static_cast<long long>(std::ceil(seconds / part - seconds));
    std::string clock(32, '\0');
    clock.resize(
        std::snprintf(clock.data(), clock.size(), ", %02lld:%02lld left", left / 60, left % 60));
    text += clock;
  }
  return text;
}

}  // namespace arbox::cli
