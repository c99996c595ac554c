#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <thread>

#include "arbox/cli/latency.h"
#include "arbox/io/detection_json.h"
#include "support/program.h"

namespace arbox::testing {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

const std::string kStreet = ARBOX_EXAMPLES "/data/street.bin";

bool wait_until(const std::function<bool()>& condition, double seconds = 20) {
  for (int i = 0; i < seconds * 200; ++i) {
    if (condition()) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  return false;
}

std::string content(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

/// `arbox watch` in the background; killed at the end of the scope.
class Watch {
 public:
  Watch(const TemporaryDirectory& folder, std::vector<std::string> more = {})
      : log_(folder / "out/watch.log") {
    std::vector<std::string> words = {std::getenv("ARBOX_PROGRAM"),
                                      "watch",
                                      folder / "in",
                                      "--output",
                                      folder / "out",
                                      "--detector",
                                      "cluster_fit"};
    words.insert(words.end(), more.begin(), more.end());
    const std::size_t before = starts();
    process_ = ::fork();
    if (process_ == 0) {
      std::vector<char*> arguments;
      for (std::string& one : words) arguments.push_back(one.data());
      arguments.push_back(nullptr);
      ::close_range(3, ~0U, 0);
      std::freopen((folder / "stdout").c_str(), "w", stdout);
      std::freopen((folder / "stderr").c_str(), "w", stderr);
      ::execv(arguments[0], arguments.data());
      ::_exit(127);
    }
    EXPECT_TRUE(wait_until([&] { return starts() > before; }));
  }
  ~Watch() {
    if (process_ > 0) stop(SIGKILL);
  }

  /// The exit code, or 128 + the signal.
  int stop(int signal) {
    ::kill(process_, signal);
    return wait();
  }
  int wait() {
    int status = 0;
    ::waitpid(process_, &status, 0);
    process_ = -1;
    return WIFSIGNALED(status) ? 128 + WTERMSIG(status) : WEXITSTATUS(status);
  }
  /// Bytes that the process has in memory.
  double memory() const {
    std::ifstream file("/proc/" + std::to_string(process_) + "/statm");
    double size = 0, resident = 0;
    file >> size >> resident;
    return resident * static_cast<double>(::sysconf(_SC_PAGESIZE));
  }

 private:
  std::size_t starts() const {
    const std::string text = content(log_);
    std::size_t count = 0;
    for (std::size_t at = text.find("watching "); at != std::string::npos;
         at = text.find("watching ", at + 1)) {
      ++count;
    }
    return count;
  }

  std::filesystem::path log_;
  pid_t process_ = -1;
};

/// The names of the scans in the results, in order; with "!" for those that were skipped.
std::vector<std::string> results(const TemporaryDirectory& folder) {
  std::vector<std::string> names;
  std::istringstream lines(content(folder / "out/detections.jsonl"));
  for (std::string line; std::getline(lines, line) && !lines.eof();) {
    const auto json = nlohmann::json::parse(line);
    names.push_back(json["file"]["name"].get<std::string>() + (json.contains("error") ? "!" : ""));
  }
  return names;
}

bool has_results(const TemporaryDirectory& folder, std::size_t count) {
  return wait_until([&] { return results(folder).size() >= count; });
}

/// Four points; `i` makes the content differ.
std::string tiny_scan(int i) {
  const float points[16] = {1, 2, 3, 0, 1, 2, 4, 0, 2, 2, 3, 0, 5, static_cast<float>(i), 1, 0};
  return {reinterpret_cast<const char*>(points), sizeof points};
}

/// As writers should: under another name, then renamed.
void deliver(const TemporaryDirectory& folder, const std::string& name, const std::string& bytes) {
  const auto part = folder.write("in/" + name + ".part", bytes);
  std::filesystem::rename(part, folder / ("in/" + name));
}

TEST(Watch, TakesClosedAndRenamedScansInOrderOfArrival) {
  const TemporaryDirectory folder;
  folder.write("in/z.bin", tiny_scan(1));
  std::this_thread::sleep_for(std::chrono::milliseconds(20));
  folder.write("in/a.bin", tiny_scan(2));
  Watch watch(folder, {"--channels", "4"});
  folder.write("in/m.bin", tiny_scan(3));
  deliver(folder, "b.bin", slurp(kStreet));
  folder.write("in/.hidden.bin", tiny_scan(4));
  folder.write("in/notes.txt", "not a scan");
  folder.write("in/later.bin.tmp", tiny_scan(5));
  folder.write("in/c.bin", tiny_scan(6));
  ASSERT_TRUE(has_results(folder, 5));
  EXPECT_EQ(watch.stop(SIGTERM), 0);
  EXPECT_THAT(results(folder), ElementsAre("z.bin", "a.bin", "m.bin", "b.bin", "c.bin"));
  const auto scans = io::read_detections_json(folder / "out/detections.jsonl");
  EXPECT_EQ(scans[3].source, folder / "in/b.bin");
  EXPECT_GE(scans[3].detections.size(), 8u);
  EXPECT_THAT(content(folder / "stdout"), HasSubstr("5 scans, 0 skipped, latency median "));
  EXPECT_EQ(content(folder / "stderr"), "");
  EXPECT_THAT(content(folder / "out/watch.log"), HasSubstr("b.bin: "));
  EXPECT_THAT(content(folder / "out/watch.log"), HasSubstr("latency "));
}

TEST(Watch, FlushesEachResultAtOnce) {
  const TemporaryDirectory folder;
  std::filesystem::create_directories(folder / "in");
  Watch watch(folder, {"--channels", "4"});
  for (std::size_t i = 1; i <= 3; ++i) {
    deliver(folder, std::to_string(i) + ".bin", tiny_scan(1));
    EXPECT_TRUE(has_results(folder, i));
    EXPECT_TRUE(wait_until([&] {
      return content(folder / "out/watch.log").find(std::to_string(i) + ".bin: ") !=
             std::string::npos;
    }));
  }
}

TEST(Watch, ReportsABrokenFileAndGoesOn) {
  const TemporaryDirectory folder;
  folder.write("in/a.pcd", "VERSION nonsense\n");
  Watch watch(folder, {"--channels", "4", "--scans", "4"});
  deliver(folder, "b.bin", "123");
  deliver(folder, "c.bin", "");
  deliver(folder, "d.bin", tiny_scan(1));
  EXPECT_EQ(watch.wait(), 0);
  EXPECT_THAT(results(folder), ElementsAre("a.pcd!", "b.bin!", "c.bin!", "d.bin"));
  EXPECT_THAT(content(folder / "stderr"), HasSubstr("b.bin"));
  EXPECT_THAT(content(folder / "out/watch.log"), HasSubstr("c.bin: skipped: "));
  EXPECT_THAT(content(folder / "stdout"), HasSubstr("4 scans, 3 skipped"));
  EXPECT_EQ(io::read_detections_json(folder / "out/detections.jsonl").size(), 4u);

  // What was skipped is not tried again.
  deliver(folder, "e.bin", tiny_scan(2));
  Watch(folder, {"--channels", "4", "--scans", "1"}).wait();
  EXPECT_EQ(results(folder).back(), "e.bin");
  EXPECT_EQ(results(folder).size(), 5u);
}

TEST(Watch, TakesAFileThatIsReplacedAgainAndLeavesOneThatIsNot) {
  const TemporaryDirectory folder;
  std::filesystem::create_directories(folder / "in");
  Watch watch(folder, {"--channels", "4"});
  deliver(folder, "a.bin", tiny_scan(1));
  ASSERT_TRUE(has_results(folder, 1));
  // Closed after writing, but nothing was written.
  std::ofstream(folder / "in/a.bin", std::ios::app).close();
  deliver(folder, "b.bin", tiny_scan(1));
  ASSERT_TRUE(has_results(folder, 2));
  deliver(folder, "a.bin", tiny_scan(2));
  ASSERT_TRUE(has_results(folder, 3));
  std::filesystem::remove(folder / "in/a.bin");
  deliver(folder, "c.bin", tiny_scan(2));
  ASSERT_TRUE(has_results(folder, 4));
  EXPECT_EQ(watch.stop(SIGINT), 0);
  EXPECT_THAT(results(folder), ElementsAre("a.bin", "b.bin", "a.bin", "c.bin"));
}

TEST(Watch, WaitsForAFileThatIsStillWritten) {
  const TemporaryDirectory folder;
  std::filesystem::create_directories(folder / "in");
  std::ofstream slow(folder / "in/slow.bin", std::ios::binary);
  slow << tiny_scan(1).substr(0, 32) << std::flush;
  Watch watch(folder, {"--channels", "4"});
  deliver(folder, "a.bin", tiny_scan(1));
  ASSERT_TRUE(has_results(folder, 1));
  slow << tiny_scan(1).substr(32);
  slow.close();
  ASSERT_TRUE(has_results(folder, 2));
  EXPECT_THAT(results(folder), ElementsAre("a.bin", "slow.bin"));
  EXPECT_THAT(content(folder / "out/watch.log"), HasSubstr("slow.bin: 0 detections in 4 points"));
}

TEST(Watch, KilledAndStartedAgainNeitherRepeatsNorLosesAScan) {
  constexpr int kScans = 600;
  const TemporaryDirectory folder;
  std::filesystem::create_directories(folder / "in");
  std::jthread writer([&] {
    for (int i = 0; i < kScans; ++i) {
      deliver(folder, std::to_string(1000 + i) + ".bin", i % 50 == 7 ? "12" : tiny_scan(i));
      if (i % 20 == 0) std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
  });
  for (int i = 0; i < 12; ++i) {
    Watch watch(folder, {"--channels", "4"});
    std::this_thread::sleep_for(std::chrono::milliseconds(7 * i % 40));
    EXPECT_EQ(watch.stop(SIGKILL), 128 + SIGKILL);
  }
  writer.join();
  Watch watch(folder, {"--channels", "4"});
  ASSERT_TRUE(has_results(folder, kScans));
  deliver(folder, "last.bin", tiny_scan(1));
  ASSERT_TRUE(has_results(folder, kScans + 1));
  EXPECT_EQ(watch.stop(SIGTERM), 0);
  const auto names = results(folder);
  ASSERT_EQ(names.size(), kScans + 1u);
  for (int i = 0; i < kScans; ++i) {
    const std::string name = std::to_string(1000 + i) + ".bin" + (i % 50 == 7 ? "!" : "");
    EXPECT_EQ(std::count(names.begin(), names.end(), name), 1) << name;
  }
}

TEST(Watch, CutsALineThatAKilledProcessBegan) {
  const TemporaryDirectory folder;
  deliver(folder, "a.bin", tiny_scan(1));
  Watch(folder, {"--channels", "4", "--scans", "1"}).wait();
  const std::string whole = content(folder / "out/detections.jsonl");
  folder.write("out/detections.jsonl", whole + whole.substr(0, whole.size() / 2));
  deliver(folder, "b\xff\"}, \"\n.bin", tiny_scan(2));
  Watch(folder, {"--channels", "4", "--scans", "1"}).wait();
  EXPECT_EQ(results(folder).size(), 2u);
  EXPECT_TRUE(content(folder / "out/detections.jsonl").starts_with(whole));
  // A name that is no UTF-8 is found again.
  deliver(folder, "c.bin", tiny_scan(2));
  Watch(folder, {"--channels", "4", "--scans", "1"}).wait();
  EXPECT_EQ(results(folder).size(), 3u);
  EXPECT_EQ(results(folder).back(), "c.bin");
}

TEST(Watch, MemoryDoesNotGrowWithTheScans) {
  constexpr std::size_t kScans = 400;
  const TemporaryDirectory folder;
  std::filesystem::create_directories(folder / "in");
  Watch watch(folder, {"--channels", "4", "--threads", "1"});
  std::array<double, 2> memory{};
  for (std::size_t half = 0; half < 2; ++half) {
    for (std::size_t i = 0; i < kScans; ++i) {
      deliver(folder, std::to_string(half) + "_" + std::to_string(i) + ".bin", tiny_scan(1));
    }
    ASSERT_TRUE(has_results(folder, (half + 1) * kScans));
    memory[half] = watch.memory();
  }
  EXPECT_LT(memory[1], 1.05 * memory[0]);
}

TEST(Watch, RefusesWhatCannotWork) {
  const TemporaryDirectory folder;
  std::filesystem::create_directories(folder / "in");
  expect_one_line_error(run_arbox({"watch"}), 2, {"folder"});
  expect_one_line_error(run_arbox({"watch", folder / "none"}), 1, {"none", "a folder to watch"});
  expect_one_line_error(run_arbox({"watch", folder.write("file", "")}), 1, {"file"});
  expect_one_line_error(run_arbox({"watch", folder / "in", "--scans", "0"}), 2, {"--scans"});
  expect_one_line_error(run_arbox({"watch", folder / "in", "--detector", "none"}), 2, {"none"});
  expect_one_line_error(run_arbox({"watch", folder / "in", "--output", folder / "file/x"}), 1,
                        {"file/x"});
  folder.write("other/detections.jsonl", "{\"source\": \"a\", \"detections\": []}\n");
  expect_one_line_error(run_arbox({"watch", folder / "in", "--output", folder / "other"}), 1,
                        {"detections.jsonl:1", "--output"});
  Watch watch(folder);
  expect_one_line_error(run_arbox({"watch", folder / "in", "--output", folder / "out"}), 1,
                        {"another 'arbox watch'"});
  std::filesystem::remove(folder / "in");
  EXPECT_EQ(watch.wait(), 1);
  EXPECT_THAT(content(folder / "stderr"), HasSubstr("removed or moved"));
}

TEST(LatencyCount, TellsQuantilesWithinAStep) {
  cli::LatencyCount count;
  EXPECT_EQ(count.text(), "latency median 0.0 ms, 95 % 0.0 ms, longest 0.0 ms");
  for (int i = 1; i <= 1000; ++i) count.add(0.1 * i);
  EXPECT_EQ(count.count(), 1000u);
  EXPECT_NEAR(count.quantile(0.5), 50, 2.6);
  EXPECT_NEAR(count.quantile(0.95), 95, 5);
  EXPECT_DOUBLE_EQ(count.quantile(1), 100);
  count.add(0);
  count.add(1e12);
  EXPECT_EQ(count.count(), 1002u);
}

}  // namespace
}  // namespace arbox::testing
