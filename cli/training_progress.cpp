#include "arbox/cli/training_progress.h"

#include <sys/ioctl.h>
#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <vector>

#include "arbox/base/names.h"

namespace arbox::cli {
namespace {

constexpr auto kRedraw = std::chrono::milliseconds(200);
constexpr auto kNextLine = std::chrono::seconds(10);

std::string number(double value) {
  std::string text(32, '\0');
  text.resize(static_cast<std::size_t>(std::snprintf(text.data(), text.size(), "%.3g", value)));
  return text;
}

std::string clock(double seconds) {
  if (!std::isfinite(seconds) || seconds < 0) return "?";
  const auto whole = static_cast<long long>(std::ceil(seconds));
  std::string text(48, '\0');
  const int length = whole >= 3600 ? std::snprintf(text.data(), text.size(), "%lld:%02lld:%02lld",
                                                   whole / 3600, whole / 60 % 60, whole % 60)
                                   : std::snprintf(text.data(), text.size(), "%02lld:%02lld",
                                                   whole / 60, whole % 60);
  text.resize(static_cast<std::size_t>(length));
  return text;
}

std::string figures_text(const std::map<std::string, double>& figures) {
  std::vector<std::string> parts;
  for (const auto& [name, value] : figures) parts.push_back(name + " " + number(value));
  return join(parts, ", ");
}

/// A line that is longer than the terminal is wide could not be drawn over.
std::string cut_to_terminal(const std::string& text, int descriptor) {
  winsize size{};
  const bool known = ::ioctl(descriptor, TIOCGWINSZ, &size) == 0 && size.ws_col > 10;
  const std::size_t width = known ? size.ws_col - 1U : 79;
  return text.size() <= width ? text : text.substr(0, width - 3) + "...";
}

}  // namespace

std::string training_text(const training::StepReport& report) {
  const std::string terms = figures_text(report.terms);
  return "step " + std::to_string(report.step) + "/" + std::to_string(report.steps) + ", " +
         clock(report.seconds_left) + " left, loss " + number(report.loss) +
         (report.skipped ? " (skipped)" : "") + (terms.empty() ? "" : " (" + terms + ")") +
         ", epoch " + number(report.epoch) + ", rate " + number(report.learning_rate) + ", " +
         number(report.scenes_per_second) + " scenes/s";
}

std::string training_text(const training::ValidationReport& report) {
  return "validation after step " + std::to_string(report.step) + ": " +
         figures_text(report.figures);
}

TrainingProgress::TrainingProgress(int descriptor)
    : descriptor_(descriptor), terminal_(::isatty(descriptor) == 1), next_(Clock::now()) {}

TrainingProgress::~TrainingProgress() {
  if (drawn_) write(erase());
}

void TrainingProgress::on_step(const training::StepReport& report) {
  const auto now = Clock::now();
  if (now < next_ && report.step != report.steps) return;
  const std::string text = training_text(report);
  if (terminal_) {
    write(erase() + cut_to_terminal(text, descriptor_));
    drawn_ = true;
    next_ = now + kRedraw;
  } else {
    write(text + "\n");
    next_ = now + kNextLine;
  }
}

void TrainingProgress::on_validation(const training::ValidationReport& report) {
  write(erase() + training_text(report) + "\n");
  drawn_ = false;
}

std::string TrainingProgress::erase() const { return drawn_ ? "\r\x1b[K" : ""; }

void TrainingProgress::write(const std::string& text) const {
  // A terminal that went away is no reason to stop the work.
  [[maybe_unused]] const auto written = ::write(descriptor_, text.data(), text.size());
}

}  // namespace arbox::cli
