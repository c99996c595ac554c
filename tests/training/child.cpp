#include "training/child.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <cstdlib>
#include <fstream>
#include <system_error>

#include "arbox/training/checkpoint.h"

namespace arbox::training::testing {
namespace {

using Clock = std::chrono::steady_clock;

Clock::time_point after(double seconds) {
  return Clock::now() +
         std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds));
}

}  // namespace

Child::Child(const std::vector<std::string>& arguments,
             const std::map<std::string, std::string>& environment) {
  std::array<int, 2> ends{};
  if (::pipe2(ends.data(), O_CLOEXEC) != 0) {
    throw std::system_error(errno, std::generic_category(), "pipe");
  }
  process_ = ::fork();
  if (process_ == 0) {
    // SIGTSTP stops nothing in an orphaned process group, which a test's may be.
    ::setpgid(0, 0);
    ::dup2(ends[1], STDOUT_FILENO);
    ::dup2(ends[1], STDERR_FILENO);
    for (const auto& [name, value] : environment) ::setenv(name.c_str(), value.c_str(), 1);
    std::vector<char*> words{const_cast<char*>(ARBOX_TOY_PROGRAM)};
    for (const std::string& word : arguments) words.push_back(const_cast<char*>(word.c_str()));
    words.push_back(nullptr);
    ::execv(ARBOX_TOY_PROGRAM, words.data());
    ::_exit(127);
  }
  ::close(ends[1]);
  pipe_ = ends[0];
}

Child::~Child() {
  if (process_ > 0) {
    ::kill(process_, SIGKILL);
    ::waitpid(process_, nullptr, 0);
  }
  ::close(pipe_);
}

void Child::send(int signal) const { ::kill(process_, signal); }

bool Child::read_some(double seconds) {
  pollfd end{pipe_, POLLIN, 0};
  if (::poll(&end, 1, static_cast<int>(seconds * 1000)) <= 0) return false;
  std::array<char, 4096> buffer{};
  const ssize_t count = ::read(pipe_, buffer.data(), buffer.size());
  if (count > 0) output_.append(buffer.data(), static_cast<std::size_t>(count));
  return count > 0;
}

bool Child::wait_for_line(const std::string& beginning, double seconds) {
  const auto found = [&] { return ("\n" + output_).find("\n" + beginning) != std::string::npos; };
  while (!found()) {
    if (!read_some(seconds)) return false;
  }
  return true;
}

int Child::wait(double seconds) {
  const auto deadline = after(seconds);
  while (Clock::now() < deadline) {
    while (read_some(0.005)) {
    }
    int status = 0;
    if (::waitpid(process_, &status, WNOHANG) == process_) {
      process_ = -1;
      while (read_some(0)) {
      }
      return WIFSIGNALED(status) ? 128 + WTERMSIG(status) : WEXITSTATUS(status);
    }
    ::usleep(1000);
  }
  return -1;
}

char Child::state() const {
  std::ifstream file("/proc/" + std::to_string(process_) + "/stat");
  std::string text;
  std::getline(file, text);
  const std::size_t place = text.rfind(") ");
  return place == std::string::npos ? '?' : text[place + 2];
}

void run_toy(const std::vector<std::string>& arguments) {
  Child child(arguments);
  EXPECT_EQ(child.wait(), 0) << child.output();
}

void expect_same_checkpoint(const std::string& folder, const std::string& expected) {
  const Checkpoint left = read_checkpoint(checkpoint_file(folder));
  const Checkpoint right = read_checkpoint(checkpoint_file(expected));
  EXPECT_EQ(left.step, right.step);
  ASSERT_EQ(left.tensors.size(), right.tensors.size());
  for (const auto& [name, tensor] : left.tensors) {
    EXPECT_TRUE(tensor.equal(right.tensors.at(name))) << name;
  }
}

}  // namespace arbox::training::testing
