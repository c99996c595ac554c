#pragma once

#include <condition_variable>
#include <mutex>
#include <thread>

namespace arbox::training {

/// Seconds for which the process could run since the clock was made: time in which it was stopped
/// (SIGTSTP, SIGSTOP) does not count. Good to about half a second a stop.
class ActiveClock {
 public:
  ActiveClock();
  ~ActiveClock();
  ActiveClock(const ActiveClock&) = delete;
  ActiveClock& operator=(const ActiveClock&) = delete;

  double seconds();

 private:
  void tick();
  void advance();

  std::mutex mutex_;
  std::condition_variable ending_;
  bool ended_ = false;
  double active_ = 0;
  double last_;
  std::thread ticker_;
};

}  // namespace arbox::training
