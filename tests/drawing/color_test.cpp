#include "arbox/drawing/color.h"

#include <gtest/gtest.h>

#include <cstdlib>

#include <cmath>

namespace arbox::drawing {
namespace {

double luminance(Color color) {
  const auto linear = [](int v) { return std::pow(v / 255.0, 2.2); };
  return 0.2126 * linear(color.r) + 0.7152 * linear(color.g) + 0.0722 * linear(color.b);
}

TEST(Color, MixKeepsItsEndsAndIsMonotoneBetweenThem) {
  const Color black = {0, 0, 0}, white = {255, 255, 255};
  EXPECT_EQ(mix(black, white, 0.0), black);
  EXPECT_EQ(mix(black, white, 1.0), white);
  EXPECT_EQ(mix(black, white, -3.0), black);
  EXPECT_EQ(mix(black, white, 3.0), white);
  for (int i = 1; i <= 10; ++i) {
    EXPECT_GT(luminance(mix(black, white, i / 10.0)), luminance(mix(black, white, (i - 1) / 10.0)));
  }
}

TEST(Color, MapGetsDarkerOnLightAndBrighterOnDark) {
  for (int i = 1; i <= 20; ++i) {
    EXPECT_LT(luminance(map_color(i / 20.0, false)), luminance(map_color((i - 1) / 20.0, false)));
    EXPECT_GT(luminance(map_color(i / 20.0, true)), luminance(map_color((i - 1) / 20.0, true)));
  }
  EXPECT_EQ(map_color(-1.0, false), map_color(0.0, false));
  EXPECT_EQ(map_color(2.0, false), map_color(1.0, false));
  EXPECT_EQ(map_color(NAN, false), map_color(0.0, false));
}

TEST(Color, ClassesKeepTheirColorWhateverElseIsDrawn) {
  EXPECT_EQ(class_color("sofa"), class_color("sofa"));
  EXPECT_NE(class_color("Car"), class_color("Pedestrian"));
  EXPECT_NE(class_color("Car"), class_color("Cyclist"));
  EXPECT_NE(class_color("Pedestrian"), class_color("Cyclist"));
}

TEST(Color, FurnitureThatStandsTogetherDiffers) {
  const char* const kClasses[] = {"bathtub",   "bed",     "bookshelf",    "cabinet",
                                  "chair",     "curtain", "desk",         "door",
                                  "dresser",   "lamp",    "window",       "counter",
                                  "picture",   "table",   "night_stand",  "sofa",
                                  "sink",      "toilet",  "refrigerator", "showercurtrain",
                                  "garbagebin"};
  for (const char* one : kClasses) {
    for (const char* other : kClasses) {
      const Color a = class_color(one), b = class_color(other);
      const int apart = std::abs(a.r - b.r) + std::abs(a.g - b.g) + std::abs(a.b - b.b);
      EXPECT_TRUE(one == other || apart >= 40) << one << " and " << other;
    }
  }
}

TEST(Color, PaletteHasSevenColorsAndRepeats) {
  for (int i = 0; i < 7; ++i) {
    for (int j = 0; j < i; ++j) EXPECT_NE(palette_color(i), palette_color(j));
    EXPECT_EQ(palette_color(i), palette_color(i + 7));
  }
}

}  // namespace
}  // namespace arbox::drawing
