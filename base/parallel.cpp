#include "arbox/base/parallel.h"

#include <omp.h>

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <string>

#include "arbox/base/error.h"

namespace arbox {
namespace {

std::atomic<int> chosen_threads{0};
thread_local int scoped_threads = 0;
// Before other libraries change it: LibTorch sets OpenMP's number to that of physical cores when it
// first runs something, which is half of what two threads a core allow.
const int threads_at_start = omp_get_max_threads();

}  // namespace

int default_threads() {
  if (scoped_threads > 0) return scoped_threads;
  const int chosen = chosen_threads.load();
  return chosen > 0 ? chosen : threads_at_start;
}

void set_default_threads(int count) {
  if (count < 1) {
    throw InvalidArgument("set_default_threads: expected at least 1, got " + std::to_string(count));
  }
  chosen_threads = count;
}

ThreadScope::ThreadScope(int count) : outer_(scoped_threads), outer_openmp_(omp_get_max_threads()) {
  scoped_threads = count > 0 ? count : default_threads();
  omp_set_num_threads(scoped_threads);
}

ThreadScope::~ThreadScope() {
  scoped_threads = outer_;
  omp_set_num_threads(outer_openmp_);
}

void parallel_for(std::int64_t count, std::int64_t grain, int threads,
                  const std::function<void(std::int64_t, std::int64_t)>& body) {
  if (count <= 0) return;
  grain = std::max<std::int64_t>(grain, 1);
  const std::int64_t ranges = (count + grain - 1) / grain;
  const int workers =
      static_cast<int>(std::min<std::int64_t>(ranges, threads > 0 ? threads : default_threads()));
  const auto run = [&](std::int64_t range) {
    body(range * grain, std::min(count, (range + 1) * grain));
  };
  if (workers <= 1 || omp_in_parallel()) {
    for (std::int64_t range = 0; range < ranges; ++range) run(range);
    return;
  }
  std::exception_ptr failure;
  std::mutex failure_mutex;
  std::atomic<bool> stopped{false};
#pragma omp parallel for num_threads(workers) schedule(dynamic, 1)
  for (std::int64_t range = 0; range < ranges; ++range) {
    if (stopped) continue;
    try {
      run(range);
    } catch (...) {
      const std::scoped_lock lock(failure_mutex);
      if (!failure) failure = std::current_exception();
      stopped = true;
    }
  }
  if (failure) std::rethrow_exception(failure);
}

}  // namespace arbox
