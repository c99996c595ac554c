#pragma once

#include <sys/types.h>

#include <map>
#include <string>
#include <vector>

namespace arbox::training::testing {

/// A running toy program (toy_program.cpp), killed at the end of the scope.
class Child {
 public:
  explicit Child(const std::vector<std::string>& arguments,
                 const std::map<std::string, std::string>& environment = {});
  ~Child();
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;

  void send(int signal) const;
  /// Waits until the program has printed a line that begins so; false if it ended or was silent
  /// for `seconds` before.
  bool wait_for_line(const std::string& beginning, double seconds = 60);
  /// Waits for the end: the exit code, 128 + the signal that ended it, or -1 if it still runs after
  /// `seconds`.
  int wait(double seconds = 60);
  /// State letter of the kernel: R running, S sleeping, T stopped.
  char state() const;

  /// What was printed up to now.
  const std::string& output() const { return output_; }

 private:
  bool read_some(double seconds);

  pid_t process_ = -1;
  int pipe_ = -1;
  std::string output_;
};

/// Runs the toy program to its end and expects success.
void run_toy(const std::vector<std::string>& arguments);

/// Expects two folders to hold checkpoints of the same step with equal tensors to the last bit.
void expect_same_checkpoint(const std::string& folder, const std::string& expected);

}  // namespace arbox::training::testing
