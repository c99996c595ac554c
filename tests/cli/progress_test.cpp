#include "arbox/cli/progress.h"

#include <gtest/gtest.h>
#include <pty.h>
#include <unistd.h>

#include <array>
#include <thread>

namespace {

using arbox::cli::Progress;
using arbox::cli::progress_text;

struct Terminal {
  int outer = -1;
  int inner = -1;

  Terminal() { EXPECT_EQ(::openpty(&outer, &inner, nullptr, nullptr, nullptr), 0); }
  ~Terminal() {
    ::close(outer);
    ::close(inner);
  }
  std::string shown() const {
    ::write(inner, "|", 1);
    std::string text;
    std::array<char, 4096> buffer{};
    while (!text.ends_with('|')) {
      const ssize_t count = ::read(outer, buffer.data(), buffer.size());
      if (count <= 0) break;
      text.append(buffer.data(), static_cast<std::size_t>(count));
    }
    return text;
  }
};

TEST(ProgressText, ShowsPartCountAndTimeLeft) {
  EXPECT_EQ(progress_text("detect", 0, 4, 1), "detect [------------------------------] 0/4");
  EXPECT_EQ(progress_text("detect", 2, 4, 61),
            "detect [###############---------------] 2/4, 01:01 left");
  EXPECT_EQ(progress_text("detect", 4, 4, 10), "detect [##############################] 4/4");
  EXPECT_EQ(progress_text("detect", 9, 4, 10), "detect [##############################] 9/4");
  EXPECT_EQ(progress_text("detect", 0, 0, 0), "detect [##############################] 0/0");
}

TEST(Progress, DrawsOnATerminalAndErasesItself) {
  const Terminal terminal;
  {
    Progress progress("work", 3, terminal.inner);
    std::this_thread::sleep_for(std::chrono::milliseconds(520));
    progress.advance();
  }
  const std::string shown = terminal.shown();
  EXPECT_NE(shown.find("work [##########"), std::string::npos) << shown;
  EXPECT_TRUE(shown.ends_with("\r\x1b[K|")) << shown;
}

TEST(Progress, SaysNothingOfShortWork) {
  const Terminal terminal;
  {
    Progress progress("work", 3, terminal.inner);
    progress.advance(3);
  }
  EXPECT_EQ(terminal.shown(), "|");
}

TEST(Progress, SaysNothingOutsideATerminal) {
  std::array<int, 2> ends{};
  ASSERT_EQ(::pipe(ends.data()), 0);
  {
    Progress progress("work", 3, ends[1]);
    std::this_thread::sleep_for(std::chrono::milliseconds(520));
    progress.advance();
  }
  ::close(ends[1]);
  char letter = 0;
  EXPECT_EQ(::read(ends[0], &letter, 1), 0);
  ::close(ends[0]);
}

}  // namespace
