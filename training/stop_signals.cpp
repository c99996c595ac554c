#include "arbox/training/stop_signals.h"

#include <atomic>

namespace arbox::training {
namespace {

std::atomic<int> came{0};
static_assert(std::atomic<int>::is_always_lock_free);

void note(int signal) { came = signal; }

}  // namespace

StopSignals::StopSignals() {
  came = 0;
  struct sigaction action {};
  action.sa_handler = note;
  action.sa_flags = SA_RESTART | static_cast<int>(SA_RESETHAND);
  ::sigemptyset(&action.sa_mask);
  for (std::size_t i = 0; i < kSignals.size(); ++i) ::sigaction(kSignals[i], &action, &before_[i]);
}

StopSignals::~StopSignals() {
  for (std::size_t i = 0; i < kSignals.size(); ++i) {
    ::sigaction(kSignals[i], &before_[i], nullptr);
  }
}

int StopSignals::received() { return came; }

}  // namespace arbox::training
