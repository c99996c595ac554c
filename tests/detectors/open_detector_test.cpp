#include "arbox/detectors/open_detector.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/program.h"
#include "support/refusal.h"

namespace arbox::testing {
namespace {

using detectors::open_detector;
using ::testing::AllOf;
using ::testing::HasSubstr;

TEST(OpenDetector, OpensBuiltInDetectorsWithChanges) {
  EXPECT_TRUE(open_detector("cluster_fit")->detect({}).detections.empty());
  EXPECT_NE(open_detector("cluster_fit", {"max_range=20", "ground.thickness=0.3"}), nullptr);
  EXPECT_THAT(refusal<ConfigError>([] { open_detector("cluster_fit", {"max_rage=20"}); }),
              HasSubstr("nearest is 'max_range'"));
}

TEST(OpenDetector, NamesWhatThereIs) {
  const TemporaryDirectory models;
  models.write("car.arbox", "no archive");
  ::setenv("ARBOX_MODEL_PATH", models.path().c_str(), 1);
  EXPECT_THAT(refusal([] { open_detector("cluster_fat"); }),
              AllOf(HasSubstr("nearest is 'cluster_fit'"), HasSubstr("known: car")));
  ::unsetenv("ARBOX_MODEL_PATH");
  EXPECT_THAT(refusal([] { open_detector(""); }), HasSubstr("cluster_fit"));
  EXPECT_THAT(refusal<IoError>([] { open_detector("missing.arbox"); }), HasSubstr("missing.arbox"));
  EXPECT_THAT(refusal<IoError>([] { open_detector("some/where"); }), HasSubstr("some/where"));
}

TEST(OpenDetector, TellsWhichOptionsDoNotFit) {
  Registry registry = detectors::make_detector_registry();
  const TemporaryDirectory folder;
  const auto file = folder.write("options.yaml", "max_range: 20\n");
  EXPECT_NE(detectors::create_detector("cluster_fit", file, {"min_points=12"}, registry), nullptr);
  EXPECT_THAT(refusal<detectors::OverrideError>([&] {
                detectors::create_detector("cluster_fit", file, {"max_rage=20"}, registry);
              }),
              HasSubstr("nearest is 'max_range'"));
  const auto broken = folder.write("broken.yaml", "max_rage: 20\n");
  EXPECT_THAT(refusal<ConfigError>(
                  [&] { detectors::create_detector("cluster_fit", broken, {}, registry); }),
              HasSubstr("broken.yaml:1"));
  EXPECT_THROW(detectors::create_detector("cluster_fit", folder / "none.yaml", {}, registry),
               IoError);
  EXPECT_THAT(refusal([&] { detectors::create_detector("cluster_fat", {}, {}, registry); }),
              HasSubstr("nearest is 'cluster_fit'"));
}

TEST(OpenDetector, KnowsWhetherTheShippedModelIsThere) {
  const TemporaryDirectory models;
  ::setenv("ARBOX_MODEL_PATH", models.path().c_str(), 1);
  models.write(std::string(detectors::kShippedModel) + ".arbox", "no archive");
  EXPECT_TRUE(detectors::has_shipped_model());
  EXPECT_THROW(detectors::open_model(detectors::kShippedModel), FormatError);
  ::unsetenv("ARBOX_MODEL_PATH");
}

}  // namespace
}  // namespace arbox::testing
