#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <cstdlib>
#include <fstream>
#include <future>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "support/program.h"

// Xlib's macros break other headers: last.
#include <X11/Xlib.h>
#include <X11/Xutil.h>
#include <X11/keysym.h>

namespace arbox::testing {
namespace {

const std::string kStreet = ARBOX_EXAMPLES "/data/street.bin";

TEST(ViewInteractive, SaysSoWithoutADisplay) {
  expect_one_line_error(
      run_arbox({"view", "--cloud", kStreet, "--interactive"}, {.environment = {{"DISPLAY", ""}}}),
      2, {"display", "DISPLAY is not set", "--html"});
  expect_one_line_error(run_arbox({"view", "--cloud", kStreet, "--interactive"},
                                  {.environment = {{"DISPLAY", ":4242"}}}),
                        2, {"':4242' cannot be opened"});
}

/// A display without a screen.
class Xvfb {
 public:
  Xvfb() {
    std::array<int, 2> ends{};
    if (::pipe(ends.data()) != 0) return;
    process_ = ::fork();
    if (process_ == 0) {
      const std::string descriptor = std::to_string(ends[1]);
      std::freopen("/dev/null", "w", stderr);
      ::execlp("Xvfb", "Xvfb", "-displayfd", descriptor.c_str(), "-screen", "0", "1280x800x24",
               "-nolisten", "tcp", nullptr);
      ::_exit(127);
    }
    ::close(ends[1]);
    char digit = 0;
    while (::read(ends[0], &digit, 1) == 1 && digit != '\n') number_ += digit;
    ::close(ends[0]);
  }
  ~Xvfb() {
    ::kill(process_, SIGTERM);
    ::waitpid(process_, nullptr, 0);
  }
  /// Empty if there is no Xvfb.
  std::string name() const { return number_.empty() ? "" : ":" + number_; }

 private:
  pid_t process_ = -1;
  std::string number_;
};

/// The viewer's window, found by its title.
class Window {
 public:
  explicit Window(const std::string& display) : display_(::XOpenDisplay(display.c_str())) {}
  ~Window() { ::XCloseDisplay(display_); }

  /// The title, once it begins with `start`; what it is after 20 s otherwise.
  std::string wait_for_title(const std::string& start) {
    std::string title;
    for (int i = 0; i < 400; ++i) {
      title = find(DefaultRootWindow(display_));
      if (title.starts_with(start)) return title;
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
    }
    return title;
  }

  void press(KeySym key) {
    XKeyEvent event{};
    event.display = display_;
    event.window = window_;
    event.root = DefaultRootWindow(display_);
    event.same_screen = True;
    event.keycode = ::XKeysymToKeycode(display_, key);
    for (const int type : {KeyPress, KeyRelease}) {
      event.type = type;
      ::XSendEvent(display_, window_, True, type == KeyPress ? KeyPressMask : KeyReleaseMask,
                   reinterpret_cast<XEvent*>(&event));
    }
    ::XFlush(display_);
  }

  /// The colours of the window's pixels.
  std::vector<unsigned long> pixels() {
    XWindowAttributes size;
    ::XGetWindowAttributes(display_, window_, &size);
    XImage* image = ::XGetImage(display_, window_, 0, 0, static_cast<unsigned>(size.width),
                                static_cast<unsigned>(size.height), AllPlanes, ZPixmap);
    std::vector<unsigned long> colors;
    for (int y = 0; y < size.height; ++y) {
      for (int x = 0; x < size.width; ++x) colors.push_back(XGetPixel(image, x, y));
    }
    XDestroyImage(image);
    return colors;
  }

 private:
  std::string find(::Window parent) {
    ::Window root = 0, above = 0, *children = nullptr;
    unsigned count = 0;
    std::string title;
    if (::XQueryTree(display_, parent, &root, &above, &children, &count) == 0) return "";
    for (unsigned i = 0; i < count && title.empty(); ++i) {
      char* name = nullptr;
      if (::XFetchName(display_, children[i], &name) != 0 && name != nullptr) {
        if (std::string(name).starts_with("Arbox")) window_ = children[i], title = name;
        ::XFree(name);
      }
      if (title.empty()) title = find(children[i]);
    }
    if (children != nullptr) ::XFree(children);
    return title;
  }

  Display* display_;
  ::Window window_ = 0;
};

TEST(ViewInteractive, StepsThroughQuantilesAndClosesUnderXvfb) {
  const Xvfb screen;
  if (screen.name().empty()) GTEST_SKIP() << "needs the package xvfb";
  const TemporaryDirectory folder;
  const RunResult found = run_arbox({"detect", kStreet, "--detector", "cluster_fit", "--samples"});
  ASSERT_EQ(found.exit_code, 0) << found.errors;
  const std::string boxes = folder.write("boxes.json", found.output);
  auto viewer = std::async(std::launch::async, [&] {
    return run_arbox({"view", "--cloud", kStreet, "--boxes", boxes, "--interactive"},
                     {.environment = {{"DISPLAY", screen.name()}}, .timeout_seconds = 60});
  });
  Window window(screen.name());
  EXPECT_EQ(window.wait_for_title("Arbox: q = 0.50"), "Arbox: q = 0.50");
  window.press(XK_n);
  EXPECT_EQ(window.wait_for_title("Arbox: q = 0.55"), "Arbox: q = 0.55");
  window.press(XK_b);
  window.press(XK_b);
  EXPECT_EQ(window.wait_for_title("Arbox: q = 0.45"), "Arbox: q = 0.45");
  const auto before = window.pixels();
  EXPECT_GT(std::set(before.begin(), before.end()).size(), 100u);
  window.press(XK_k);
  EXPECT_EQ(window.wait_for_title("Arbox: q = 0.45, s"), "Arbox: q = 0.45, samples");
  const auto after = window.pixels();
  ASSERT_EQ(after.size(), before.size());
  int differ = 0;
  for (std::size_t i = 0; i < after.size(); ++i) differ += after[i] != before[i];
  EXPECT_GT(differ, 1000);
  if (const char* path = std::getenv("ARBOX_TEST_PICTURE")) {
    std::ofstream picture(path, std::ios::binary);
    picture << "P6 1280 " << after.size() / 1280 << " 255\n";
    for (const unsigned long pixel : after) {
      for (const int shift : {16, 8, 0}) picture << static_cast<char>(pixel >> shift);
    }
  }
  window.press(XK_q);
  const RunResult result = viewer.get();
  EXPECT_EQ(result.exit_code, 0) << result.errors;
  EXPECT_FALSE(result.timed_out);
}

}  // namespace
}  // namespace arbox::testing
