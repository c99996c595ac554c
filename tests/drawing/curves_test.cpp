#include "arbox/drawing/curves.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numeric>

#include "arbox/base/error.h"
#include "drawing/pixels.h"

namespace arbox::drawing {
namespace {

constexpr Color kRed = {220, 0, 0};
constexpr Color kBlue = {0, 0, 220};

Panel line_panel(std::vector<double> x, std::vector<double> y) {
  Panel panel;
  panel.series = {{.name = "", .x = std::move(x), .y = std::move(y), .color = kRed}};
  return panel;
}

Image draw(const Panel& panel) { return draw_figure({&panel, 1}); }

TEST(Curves, AHorizontalLineIsOneStraightBarOfItsColor) {
  Panel panel = line_panel({0.0, 1.0}, {0.5, 0.5});
  panel.y.low = 0.0;
  panel.y.high = 1.0;
  const Image image = draw(panel);
  int first = image.height, last = -1, columns = 0;
  for (int x = 0; x < image.width; ++x) {
    bool found = false;
    for (int y = 0; y < image.height; ++y) {
      if (!close(image.at(x, y), kRed, 60)) continue;
      found = true;
      first = std::min(first, y);
      last = std::max(last, y);
    }
    columns += found;
  }
  EXPECT_GT(columns, image.width / 2);
  EXPECT_LE(last - first, 2);
  EXPECT_NEAR((first + last) / 2.0, image.height / 2.0, 25.0);
}

TEST(Curves, LargerValuesStandHigherAndToTheRight) {
  Panel panel;
  panel.series = {{.name = "", .x = {1.0}, .y = {1.0}, .markers = true, .color = kRed},
                  {.name = "", .x = {9.0}, .y = {9.0}, .markers = true, .color = kBlue}};
  const Image image = draw(panel);
  const int x = image.width / 2, y = image.height / 2;
  EXPECT_GT(count_color(image, kRed, 0, y, x, image.height, 50), 20);
  EXPECT_GT(count_color(image, kBlue, x, 0, image.width, y, 50), 20);
  EXPECT_EQ(count_color(image, kRed, x, 0, image.width, image.height, 50), 0);
}

TEST(Curves, ALegendAboveHidesNothingOfBarsThatReachTheTop) {
  Panel panel;
  panel.categories = {"a", "b"};
  panel.bars = {{.name = "first", .heights = {100.0, 100.0}, .color = kRed}};
  panel.y = {.low = 0.0, .high = 100.0};
  const Image within = draw(panel);
  panel.legend_above = true;
  const Image above = draw(panel);
  // Both bars' tops stand in one row of pixels, and only the legend's swatch above it.
  const auto reds = [&](const Image& image, int y) {
    return count_color(image, kRed, 0, y, image.width, y + 1, 60);
  };
  const auto top = [&](const Image& image) {
    int y = 0;
    while (y < image.height && reds(image, y) < image.width / 2) ++y;
    return y;
  };
  const int full = reds(above, top(above) + 2);
  for (int y = top(above) + 2; y < above.height * 3 / 4; ++y) EXPECT_EQ(reds(above, y), full) << y;
  EXPECT_LT(reds(within, top(within) + 20), full) << "or this test proves nothing";
  EXPECT_GT(count_color(above, kRed, 0, 0, above.width, top(above) - 4, 60), 50);
}

TEST(Curves, SkipsWhatIsNotFiniteAndStillDrawsTheRest) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double inf = std::numeric_limits<double>::infinity();
  const int all = count_color(draw(line_panel({0, 1, 2, 3}, {1, 1, 1, 1})), kRed, 60);
  const int some = count_color(draw(line_panel({0, 1, 2, 3}, {1, nan, 1, 1})), kRed, 60);
  EXPECT_GT(some, all / 5);
  EXPECT_LT(some, all / 2);
  EXPECT_EQ(count_color(draw(line_panel({0, 1}, {nan, inf})), kRed, 60), 0);
}

TEST(Curves, LogarithmicAxesSkipWhatIsNotPositive) {
  Panel panel = line_panel({1, 2, 3, 4}, {0.0, 10.0, 1000.0, -5.0});
  panel.y.logarithmic = true;
  EXPECT_GT(count_color(draw(panel), kRed, 60), 50);
  panel.y.low = 0.0;
  EXPECT_THROW(draw(panel), InvalidArgument);
}

TEST(Curves, NothingOfALineLeavesItsPanel) {
  std::vector<Panel> panels(2);
  panels[0] = line_panel({-100.0, 0.0, 100.0}, {-1e9, 0.5, 1e9});
  panels[0].x = {.low = 0.0, .high = 1.0};
  panels[0].y = {.low = 0.0, .high = 1.0};
  const Image image = draw_figure(panels);
  EXPECT_GT(count_color(image, kRed, 60), 0);
  EXPECT_EQ(count_color(image, kRed, image.width / 2 - 15, 0, image.width, image.height, 60), 0);
}

TEST(Curves, BarHeightsAreProportional) {
  Panel panel;
  panel.categories = {"a", "b"};
  panel.bars = {{.name = "", .heights = {1.0, 2.0}, .color = kRed}};
  const Image image = draw(panel);
  const int left = count_color(image, kRed, 0, 0, image.width / 2 + 10, image.height, 60);
  const int right = count_color(image, kRed, 60) - left;
  EXPECT_NEAR(right / static_cast<double>(left), 2.0, 0.05);
}

TEST(Curves, SizesFollowThePanels) {
  const std::vector<Panel> panels(5);
  const Image image = draw_figure(panels, {.columns = 2, .panel_width = 200, .panel_height = 150});
  EXPECT_EQ(image.width, 400);
  EXPECT_EQ(image.height, 450);
}

TEST(Curves, EqualInputGivesEqualPixels) {
  const Panel panel = line_panel({0, 1, 2}, {3, 1, 2});
  EXPECT_EQ(draw(panel).pixels, draw(panel).pixels);
}

TEST(Curves, HugeTinyAndConstantValuesAreDrawn) {
  EXPECT_GT(count_color(draw(line_panel({0, 1}, {1e300, -1e300})), kRed, 60), 0);
  EXPECT_GT(count_color(draw(line_panel({0, 1}, {1e-300, 2e-300})), kRed, 60), 0);
  EXPECT_GT(count_color(draw(line_panel({5, 5}, {7, 7})), kRed, 60), 0);
}

TEST(Curves, TextOfAnyBytesIsDrawn) {
  Panel panel = line_panel({0, 1}, {0, 1});
  panel.title = "\xff\xfe broken \xc3";
  panel.x.label = "Länge, µm – Σ";
  const Image with = draw(panel);
  panel.title.clear();
  EXPECT_NE(with.pixels, draw(panel).pixels);
}

TEST(Curves, RefusesWhatDoesNotFit) {
  EXPECT_THROW(draw_figure({}), InvalidArgument);
  EXPECT_THROW(draw(line_panel({0, 1}, {0})), InvalidArgument);
  Panel panel = line_panel({0, 1}, {0, 1});
  panel.series[0].low = {0.0};
  EXPECT_THROW(draw(panel), InvalidArgument);
  panel = {};
  panel.x = {.low = 1.0, .high = 1.0};
  EXPECT_THROW(draw(panel), InvalidArgument);
  panel = {};
  panel.bars = {{.name = "", .heights = {1.0}, .edges = {0.0, 1.0, 2.0}}};
  EXPECT_THROW(draw(panel), InvalidArgument);
  panel.bars = {{.name = "", .heights = {1.0, 2.0}, .edges = {0.0, 1.0, 1.0}}};
  EXPECT_THROW(draw(panel), InvalidArgument);
  panel.bars = {{.name = "", .heights = {1.0}}};
  EXPECT_THROW(draw(panel), InvalidArgument);
  panel = {};
  EXPECT_THROW(draw_figure({&panel, 1}, {.panel_width = 5}), InvalidArgument);
}

TEST(Histogram, CountsEachFiniteValueOnce) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const std::vector<double> values = {0.0, 0.1, 0.5, 0.9, 1.0, nan};
  const Bars bars = histogram(values, 2);
  ASSERT_EQ(bars.edges.size(), 3u);
  EXPECT_EQ(bars.heights, (std::vector<double>{2.0, 3.0}));
  const Bars inner = histogram(values, 4, "", 0.2, 0.95);
  EXPECT_EQ(std::accumulate(inner.heights.begin(), inner.heights.end(), 0.0), 2.0);
}

TEST(Histogram, EmptyAndConstantValuesAreFine) {
  EXPECT_EQ(histogram({}, 3).heights, (std::vector<double>{0.0, 0.0, 0.0}));
  const std::vector<double> same = {2.0, 2.0};
  const Bars bars = histogram(same, 3);
  EXPECT_EQ(std::accumulate(bars.heights.begin(), bars.heights.end(), 0.0), 2.0);
  EXPECT_THROW(histogram(same, 0), InvalidArgument);
  EXPECT_THROW(histogram(same, 3, "", 1.0, 1.0), InvalidArgument);
}

}  // namespace
}  // namespace arbox::drawing
