#include "arbox/base/names.h"

#include <gtest/gtest.h>

namespace {

using arbox::nearest_name;
using arbox::unknown_name_text;

TEST(NearestName, IsTheOneWithFewestEdits) {
  EXPECT_EQ(nearest_name("treshold", {"depth", "threshold", "thread"}), "threshold");
  EXPECT_EQ(nearest_name("Car", {"Van", "car", "cat"}), "car");
}

TEST(NearestName, IsEmptyWhenNothingIsNear) {
  EXPECT_EQ(nearest_name("voxel", {}), "");
  EXPECT_EQ(nearest_name("voxel_size", {"seed"}), "");
  EXPECT_EQ(nearest_name(std::string(1'000'000, 'a'), {std::string(1'000'000, 'b')}), "");
}

TEST(UnknownNameText, NamesTheNearestAndAll) {
  EXPECT_EQ(unknown_name_text("head", "four_pint", {"autoregressive", "four_point"}),
            "unknown head 'four_pint', nearest is 'four_point'; known: autoregressive, four_point");
  EXPECT_EQ(unknown_name_text("head", "x", {}), "unknown head 'x'; none is known");
}

}  // namespace
