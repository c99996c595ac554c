#include "arbox/training/active_clock.h"

#include <algorithm>
#include <chrono>

namespace arbox::training {
namespace {

constexpr auto kTick = std::chrono::milliseconds(100);
/// A busy machine may hold the ticker up; whatever is longer was a stop.
constexpr double kLongestTick = 0.5;

double now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

}  // namespace

ActiveClock::ActiveClock() : last_(now()), ticker_([this] { tick(); }) {}

ActiveClock::~ActiveClock() {
  {
    const std::scoped_lock lock(mutex_);
    ended_ = true;
  }
  ending_.notify_all();
  ticker_.join();
}

double ActiveClock::seconds() {
  const std::scoped_lock lock(mutex_);
  advance();
  return active_;
}

void ActiveClock::advance() {
  const double time = now();
  active_ += std::min(time - last_, kLongestTick);
  last_ = time;
}

void ActiveClock::tick() {
  std::unique_lock lock(mutex_);
  while (!ending_.wait_for(lock, kTick, [&] { return ended_; })) advance();
}

}  // namespace arbox::training
