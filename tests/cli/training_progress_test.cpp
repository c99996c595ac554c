#include "arbox/cli/training_progress.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <pty.h>
#include <unistd.h>

#include <array>
#include <string>

namespace {

using arbox::cli::training_text;
using arbox::cli::TrainingProgress;
using ::testing::HasSubstr;

arbox::training::StepReport report(std::int64_t step) {
  arbox::training::StepReport result;
  result.step = step;
  result.steps = 4000;
  result.epoch = 0.48;
  result.loss = 1.32;
  result.terms = {{"box", 0.4}, {"class", 0.92}};
  result.learning_rate = 0.0012;
  result.scenes_per_second = 2.1;
  result.seconds_left = 3723;
  return result;
}

TEST(TrainingText, TellsWhatAPersonWaitsFor) {
  EXPECT_EQ(
      training_text(report(120)),
      "step 120/4000, 1:02:03 left, loss 1.32 (box 0.4, class 0.92), epoch 0.48, rate 0.0012, "
      "2.1 scenes/s");
  auto skipped = report(1);
  skipped.skipped = true;
  skipped.terms.clear();
  skipped.seconds_left = 59.2;
  EXPECT_THAT(training_text(skipped), HasSubstr("01:00 left, loss 1.32 (skipped), epoch"));
  EXPECT_EQ(training_text(arbox::training::ValidationReport{7, {{"Car", 0.5}, {"Van", 1}}, 2}),
            "validation after step 7: Car 0.5, Van 1");
}

TEST(TrainingProgress, DrawsOneLineOnATerminalAndLinesElsewhere) {
  int outer = -1, inner = -1;
  ASSERT_EQ(::openpty(&outer, &inner, nullptr, nullptr, nullptr), 0);
  {
    TrainingProgress progress(inner);
    progress.on_step(report(1));
    progress.on_step(report(2));  // Too soon to be drawn.
    progress.on_validation({1, {{"Car", 0.5}}, 1});
    progress.on_step(report(4000));
  }
  ::write(inner, "|", 1);
  std::string shown;
  std::array<char, 4096> buffer{};
  while (!shown.ends_with('|')) {
    const ssize_t count = ::read(outer, buffer.data(), buffer.size());
    if (count <= 0) break;
    shown.append(buffer.data(), static_cast<std::size_t>(count));
  }
  ::close(outer);
  ::close(inner);
  EXPECT_TRUE(shown.starts_with("step 1/4000, 1:02:03 left, loss 1.32")) << shown;
  EXPECT_EQ(shown.find("step 2/4000"), std::string::npos) << shown;
  EXPECT_THAT(shown, HasSubstr("...\r\x1b[Kvalidation after step 1: Car 0.5\r\n"));
  EXPECT_TRUE(shown.ends_with("\r\x1b[K|")) << shown;
}

}  // namespace
