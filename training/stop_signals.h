#pragma once

#include <array>
#include <csignal>

namespace arbox::training {

/// While one lives, SIGTERM, SIGINT and SIGHUP ask for the end of a run instead of ending the
/// program; the second signal of a kind ends it. One at a time in a program.
class StopSignals {
 public:
  StopSignals();
  ~StopSignals();
  StopSignals(const StopSignals&) = delete;
  StopSignals& operator=(const StopSignals&) = delete;

  /// The signal that came, 0 if none did.
  static int received();

 private:
  static constexpr std::array<int, 3> kSignals = {SIGTERM, SIGINT, SIGHUP};
  std::array<struct sigaction, kSignals.size()> before_{};
};

}  // namespace arbox::training
