#pragma once

#include <condition_variable>
#include <cstdint>
#include <exception>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

namespace arbox::training {

/// Values number first, first + 1, ... below last, made ahead on threads and given in order.
template <class Value>
class OrderedPrefetch {
 public:
  /// `make` is called from several threads; with no threads, by next(). At most `ahead` >= 1 values
  /// wait to be taken.
  OrderedPrefetch(std::function<Value(std::int64_t)> make, std::int64_t first, std::int64_t last,
                  int threads, std::int64_t ahead)
      : make_(std::move(make)), given_(first), started_(first), last_(last), ahead_(ahead) {
    for (int i = 0; i < threads; ++i) threads_.emplace_back([this] { work(); });
  }

  ~OrderedPrefetch() {
    {
      const std::scoped_lock lock(mutex_);
      last_ = started_;
    }
    room_.notify_all();
    for (std::thread& thread : threads_) thread.join();
  }
  OrderedPrefetch(const OrderedPrefetch&) = delete;
  OrderedPrefetch& operator=(const OrderedPrefetch&) = delete;

  /// The next value, or the exception that making it threw. Not to be called after the last.
  Value next() {
    if (threads_.empty()) return make_(given_++);
    std::unique_lock lock(mutex_);
    ready_.wait(lock, [&] { return made_.contains(given_); });
    Made made = std::move(made_.extract(given_++).mapped());
    lock.unlock();
    room_.notify_one();
    if (made.failure) std::rethrow_exception(made.failure);
    return std::move(*made.value);
  }

 private:
  struct Made {
    std::optional<Value> value;
    std::exception_ptr failure;
  };

  void work() {
    std::unique_lock lock(mutex_);
    while (true) {
      room_.wait(lock, [&] { return started_ >= last_ || started_ < given_ + ahead_; });
      if (started_ >= last_) return;
      const std::int64_t number = started_++;
      lock.unlock();
      Made made = attempt(number);
      lock.lock();
      made_.emplace(number, std::move(made));
      ready_.notify_one();
    }
  }

  Made attempt(std::int64_t number) const {
    try {
      return {make_(number), nullptr};
    } catch (...) {
      return {std::nullopt, std::current_exception()};
    }
  }

  std::function<Value(std::int64_t)> make_;
  std::int64_t given_, started_, last_, ahead_;
  std::map<std::int64_t, Made> made_;
  std::mutex mutex_;
  std::condition_variable room_, ready_;
  std::vector<std::thread> threads_;
};

}  // namespace arbox::training
