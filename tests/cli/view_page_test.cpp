#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>
#include <string>

#include "arbox/drawing/image.h"
#include "arbox/drawing/scene_page.h"
#include "support/program.h"
#include "support/refusal.h"

namespace arbox::testing {
namespace {

using drawing::scene_page;
using geometry::Detection;
using nlohmann::json;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

const std::string kStreet = ARBOX_EXAMPLES "/data/street.bin";

json data_of(const std::string& page) {
  const std::string start = "type=\"application/json\">";
  const std::size_t from = page.find(start) + start.size();
  return json::parse(page.substr(from, page.find("</script>", from) - from));
}

Detection nested(const std::string& label) {
  Detection detection;
  detection.label = label;
  detection.score = 0.75;
  for (int i = 0; i < 10; ++i) {
    detection.samples.push_back(geometry::make_yaw_box({5, 2, 0}, {4 + 0.1 * i, 2, 1.5}, 0.3));
  }
  detection.box = detection.samples[5];
  return detection;
}

TEST(ScenePage, HoldsEverythingAndNeedsNothing) {
  const std::vector<float> points = {0, 0, 0, 10, -5, 2, 1, 1, 1};
  const drawing::Scene scene{.cloud = geometry::PointCloudView::packed(points.data(), 3),
                             .predictions = {nested("Car")},
                             .truth = {nested("Car")},
                             .photo = {}};
  const std::string page = scene_page(scene);
  EXPECT_THAT(page, AllOf(HasSubstr("default-src 'none'"), Not(HasSubstr("http://")),
                          Not(HasSubstr("https://")), Not(HasSubstr("src="))));
  const json data = data_of(page);
  EXPECT_EQ(data["points"]["count"], 3);
  // 27 bytes: nine for each point.
  const std::string packed = data["points"]["data"];
  EXPECT_EQ(packed.size(), 36u);
  EXPECT_EQ(packed.substr(0, 2), "AA");
  ASSERT_EQ(data["boxes"].size(), 2u);
  EXPECT_TRUE(data["boxes"][0]["truth"]);
  const json& box = data["boxes"][1];
  EXPECT_EQ(box["details"][0], json({"score", "0.750"}));
  EXPECT_EQ(box["corners"].size(), 24u);
  ASSERT_EQ(box["quantiles"].size(), 19u);
  for (std::size_t i = 1; i < 19; ++i) {
    EXPECT_GT(box["quantiles"][i]["q"], box["quantiles"][i - 1]["q"]);
    EXPECT_LE(box["quantiles"][i]["size"][0], box["quantiles"][i - 1]["size"][0]);
  }
  EXPECT_EQ(scene_page(scene), page);
}

TEST(ScenePage, IsSafeWithAnyNameAndAnyCloud) {
  const drawing::Scene scene{.cloud = {},
                             .predictions = {nested("</script><script>alert(1)</script><!--")},
                             .truth = {},
                             .photo = {}};
  const std::string page = scene_page(scene);
  EXPECT_THAT(page, Not(HasSubstr("alert(1)</script>")));
  EXPECT_EQ(data_of(page)["boxes"][0]["class"], "</script><script>alert(1)</script><!--");
  EXPECT_EQ(data_of(page)["points"]["count"], 0);
  EXPECT_EQ(data_of(scene_page({}))["boxes"].size(), 0u);

  const std::vector<float> points(3000, 1.5F);
  const drawing::Scene flat{.cloud = geometry::PointCloudView::packed(points.data(), 1000),
                            .predictions = {},
                            .truth = {},
                            .photo = {}};
  EXPECT_EQ(data_of(scene_page(flat, {}, 100))["points"]["count"], 100);
  EXPECT_EQ(data_of(scene_page(flat, {}, 100))["points"]["of"], 1000);
}

TEST(ScenePage, RefusesWhatCannotBeShown) {
  drawing::Scene scene;
  scene.predictions = {nested("Car")};
  scene.predictions[0].box.size.x() = -1;
  EXPECT_THAT(refusal([&] { scene_page(scene); }), HasSubstr("predictions"));
  EXPECT_THAT(refusal([&] { scene_page({}, {}, 0); }), HasSubstr("at least one point"));
}

TEST(ViewCommand, NamesTheWaysToShow) {
  expect_one_line_error(run_arbox({"view", "--cloud", kStreet}), 2,
                        {"--output", "--html", "--interactive"});
  const TemporaryDirectory folder;
  expect_one_line_error(run_arbox({"view", "--cloud", kStreet, "--html", folder / "none/a.html"}),
                        1, {"none"});
}

/// What Chromium shows of a page.
class Browser : public ::testing::Test {
 protected:
  void SetUp() override {
    for (const char* place : {"/usr/bin/chromium", "/usr/bin/chromium-browser"}) {
      if (std::filesystem::exists(place)) program_ = place;
    }
    if (program_.empty()) GTEST_SKIP() << "needs the package chromium";
    const RunResult found = run_arbox(
        {"detect", kStreet, "--detector", "cluster_fit", "--samples", "--confidence", "0.9"});
    ASSERT_EQ(found.exit_code, 0) << found.errors;
    const auto boxes = folder_.write("boxes.json", found.output);
    const RunResult shown = run_arbox({"view", "--cloud", kStreet, "--boxes", boxes, "--html",
                                       page().string(), "--title", "A street"});
    ASSERT_EQ(shown.exit_code, 0) << shown.errors;
  }

  std::filesystem::path page() const { return folder_ / "page.html"; }

  std::string open(const std::string& flag, const std::string& hash) const {
    const RunResult result =
        run(program_,
            {"--headless", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage",
             "--hide-scrollbars", "--window-size=1200,800",
             "--user-data-dir=" + (folder_ / "profile").string(), "--virtual-time-budget=2000",
             flag, "file://" + page().string() + hash},
            {.environment = {{"HOME", folder_.path().string()}}, .timeout_seconds = 120});
    EXPECT_EQ(result.exit_code, 0) << result.errors;
    return result.output;
  }

  drawing::Image picture(const std::string& hash) const {
    const std::string file = folder_ / "shot.png";
    open("--screenshot=" + file, hash);
    return drawing::read_image(file);
  }

  TemporaryDirectory folder_;
  std::string program_;
};

TEST_F(Browser, ShowsCloudBoxesSliderAndDetails) {
  const std::string dom = open("--dump-dom", "#q=0.3&box=0");
  EXPECT_THAT(dom, HasSubstr("data-ready=\"84978 points, "));
  EXPECT_THAT(dom, HasSubstr("19 quantiles\""));
  EXPECT_THAT(dom, HasSubstr("<h1 id=\"title\">A street</h1>"));
  EXPECT_THAT(dom, HasSubstr("<b id=\"share\">30 %</b>"));
  EXPECT_THAT(dom, AllOf(HasSubstr("box at q = 0.3<"), HasSubstr("uncertainty"),
                         HasSubstr("box of p = 0.9")));

  const drawing::Image wide = picture("#q=0.05"), tight = picture("#q=0.95");
  ASSERT_EQ(wide.width, 1200);
  std::set<std::uint32_t> colors;
  int differ = 0;
  for (std::size_t i = 0; i + 2 < wide.pixels.size(); i += 3) {
    colors.insert(wide.pixels[i] << 16 | wide.pixels[i + 1] << 8 | wide.pixels[i + 2]);
    differ += !std::equal(&wide.pixels[i], &wide.pixels[i] + 3, &tight.pixels[i]);
  }
  EXPECT_GT(colors.size(), 300u);
  // The slider, its text and the quantile boxes.
  EXPECT_GT(differ, 500);
}

// Dispatches what a mouse does, and notes what the page shows then.
const char kMouse[] = R"(<script>
const middleOf = box => {
  const c = [...Array(8).keys()].map(k => onScreen(corner(box.corners, k)));
  return [0, 1].map(a => c.reduce((sum, p) => sum + p[a], 0) / 8 / devicePixelRatio);
};
const mouse = (type, x, y, more) => canvas.dispatchEvent(
  new PointerEvent(type, {clientX: x, clientY: y, pointerId: 1, bubbles: true, ...more}));
canvas.setPointerCapture = () => {};
const tip = byId("tip"), seen = document.body.dataset, at = middleOf(boxes[0]);
mouse("pointermove", at[0], at[1]);
draw();
seen.over = tip.style.display + " " + tip.textContent;
seen.beside = Math.hypot(parseFloat(tip.style.left) - at[0], parseFloat(tip.style.top) - at[1]) < 400;
mouse("pointermove", innerWidth - 3, innerHeight - 3);
draw();
seen.away = tip.style.display;
const azimuth = view.azimuth, distance = view.distance;
mouse("pointerdown", 600, 400, {buttons: 1});
mouse("pointermove", 700, 400, {buttons: 1});
mouse("pointerup", 700, 400);
seen.turned = Math.abs(azimuth - view.azimuth - 0.5) < 1e-9;
canvas.dispatchEvent(new WheelEvent("wheel", {deltaY: -80, cancelable: true}));
seen.nearer = view.distance < distance;
</script>)";

TEST_F(Browser, MouseShowsDetailsTurnsAndZooms) {
  std::ofstream(page(), std::ios::app) << kMouse;
  const std::string dom = open("--dump-dom", "");
  EXPECT_THAT(dom, ::testing::ContainsRegex("data-over=\"block [A-Z][a-z]+score0\\.[0-9]+"));
  EXPECT_THAT(dom, AllOf(HasSubstr("data-beside=\"true\""), HasSubstr("data-away=\"none\""),
                         HasSubstr("data-turned=\"true\""), HasSubstr("data-nearer=\"true\"")));
}

}  // namespace
}  // namespace arbox::testing
