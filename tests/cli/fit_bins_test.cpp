#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <sstream>

#include "arbox/base/random.h"
#include "support/program.h"

namespace {

using arbox::RandomStream;
using arbox::testing::expect_one_line_error;
using arbox::testing::run_arbox;
using arbox::testing::TemporaryDirectory;
using nlohmann::json;
using ::testing::HasSubstr;

/// Boxes of ordinary road users with a class each.
std::string made_table(int rows) {
  std::ostringstream text;
  text << "x,y,z,l,w,h,yaw,class\n";
  for (int i = 0; i < rows; ++i) {
    const RandomStream random(3, static_cast<std::uint64_t>(i), 0);
    const bool car = i % 3 != 0;
    text << random.uniform(0, 0, 70) << ',' << random.uniform(1, -40, 40) << ",-1,"
         << (car ? 4.0 : 0.8) + 0.1 * random.normal(2) << ','
         << (car ? 1.6 : 0.6) + 0.05 * random.normal(3) << ',' << 1.6 + 0.1 * random.normal(4)
         << ',' << random.uniform(5, -3, 3) << ',' << (car ? "Car" : "Pedestrian") << '\n';
  }
  return text.str();
}

TEST(ConfigFitBins, FindsRangesThatReachTheGoals) {
  const TemporaryDirectory folder;
  const auto file = folder.write("boxes.csv", made_table(600));
  for (const char* kind : {"residual", "scaled", "quartile"}) {
    const auto result = run_arbox({"config", "fit-bins", file, "--kind", kind, "--json"});
    ASSERT_EQ(result.exit_code, 0) << kind << ": " << result.errors;
    const json fit = json::parse(result.output);
    EXPECT_EQ(fit.at("boxes"), 600);
    EXPECT_GE(fit.at("mean_iou").get<double>(), 0.99);
    EXPECT_LT(fit.at("overflow").get<double>(), 0.001);
    const auto codec = folder.write("codec.yaml", fit.at("codec").get<std::string>());
    const auto checked = run_arbox({"config", "check", "codec", codec});
    EXPECT_EQ(checked.exit_code, 0) << checked.errors;
  }
}

TEST(ConfigFitBins, TellsWhenTheBinsAreTooFew) {
  const TemporaryDirectory folder;
  const auto file = folder.write("boxes.csv", made_table(200));
  expect_one_line_error(run_arbox({"config", "fit-bins", file, "--set", "bins=16"}), 1,
                        {"expected at least 0.99", "--set bins=1024"});
}

TEST(ConfigFitBins, ChoosesClassesAndRefusesBadInput) {
  const TemporaryDirectory folder;
  const auto file = folder.write("boxes.csv", made_table(90));
  const auto cars = run_arbox({"config", "fit-bins", file, "--class", "Car", "--json"});
  EXPECT_EQ(json::parse(cars.output).at("boxes"), 60);
  expect_one_line_error(run_arbox({"config", "fit-bins", file, "--class", "Tram"}), 2,
                        {"hold no boxes"});
  expect_one_line_error(run_arbox({"config", "fit-bins", file, "--set", "bin=5"}), 1,
                        {"unknown key 'bin', nearest is 'bins'"});
  const auto plain = folder.write("plain.csv", "1,2,3,4,5,6,0.1\n");
  expect_one_line_error(run_arbox({"config", "fit-bins", plain, "--class", "Car"}), 2,
                        {"no column 'class'"});
  EXPECT_EQ(run_arbox({"config", "fit-bins", file, "--kind", "polar"}).exit_code, 2);
  EXPECT_EQ(run_arbox({"config", "fit-bins", folder / "absent.csv"}).exit_code, 2);
}

TEST(ConfigFitBins, ReadsKittiLabels) {
  ARBOX_REQUIRE_DATA(root, "kitti");
  const auto result = run_arbox({"config", "fit-bins", root, "--class", "Car", "--json"});
  ASSERT_EQ(result.exit_code, 0) << result.errors;
  EXPECT_GE(json::parse(result.output).at("mean_iou").get<double>(), 0.99);
}

TEST(ConfigList, KnowsHeadsAndCodecs) {
  const auto listed = run_arbox({"config", "list"});
  EXPECT_THAT(listed.output, HasSubstr("head/autoregressive"));
  EXPECT_THAT(listed.output, HasSubstr("codec"));
  EXPECT_THAT(run_arbox({"config", "show", "head/autoregressive"}).output,
              HasSubstr("likelihood_weight: 0.1"));
}

}  // namespace
