#pragma once

#include <cstdint>
#include <functional>

namespace arbox {

/// Threads that work uses when its options say 0: those of this thread's ThreadScope, else the last
/// set_default_threads(), else OMP_NUM_THREADS, else every core that this process may run on.
int default_threads();

/// Sets default_threads() for the process. count >= 1; throws InvalidArgument otherwise.
void set_default_threads(int count);

/// As long as it lives, work that is begun on this thread uses `count` threads (0: what
/// default_threads() was) where it would use default_threads(); so does OpenMP itself, and with it
/// LibTorch and oneDNN. Other threads are not concerned. Scopes may be nested.
class ThreadScope {
 public:
  explicit ThreadScope(int count);
  ~ThreadScope();
  ThreadScope(const ThreadScope&) = delete;
  ThreadScope& operator=(const ThreadScope&) = delete;

 private:
  int outer_, outer_openmp_;
};

/// Calls body(begin, end) on disjoint ranges that cover [0, count), each at most `grain` long.
///
/// Ranges are cut in the same way whatever the thread count, so a body whose ranges do not touch
/// each other gives the same bytes with any number of threads. threads = 0 means default_threads().
/// With one thread, or inside another parallel_for, the ranges run in order on the caller's thread.
/// The first exception of a body is rethrown on the caller's thread after all have stopped.
void parallel_for(std::int64_t count, std::int64_t grain, int threads,
                  const std::function<void(std::int64_t begin, std::int64_t end)>& body);

}  // namespace arbox
