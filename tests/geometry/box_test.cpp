#include "arbox/geometry/box.h"

#include <gtest/gtest.h>

#include <limits>
#include <numbers>

#include "arbox/base/error.h"

namespace {

using namespace arbox::geometry;
using Eigen::Vector3d;

TEST(Box, CornersFollowTheDocumentedOrder) {
  const auto result = corners(make_yaw_box({1, 2, 3}, {4, 2, 6}, std::numbers::pi / 2));
  EXPECT_TRUE(result[0].isApprox(Vector3d(2, 0, 0), 1e-12));
  EXPECT_TRUE(result[1].isApprox(Vector3d(2, 4, 0), 1e-12));
  EXPECT_TRUE(result[2].isApprox(Vector3d(0, 0, 0), 1e-12) || result[2].norm() < 1e-12);
  EXPECT_TRUE(result[7].isApprox(Vector3d(0, 4, 6), 1e-12));
}

TEST(Box, YawRoundTripsOverTheWholeCircle) {
  for (double angle = -3.1; angle <= 3.1; angle += 0.1) {
    const Box box = make_yaw_box({0, 0, 0}, {1, 1, 1}, angle);
    EXPECT_NEAR(yaw(box), angle, 1e-12);
    EXPECT_TRUE(is_yaw_only(box));
  }
  EXPECT_DOUBLE_EQ(yaw(make_yaw_box({0, 0, 0}, {1, 1, 1}, -std::numbers::pi)), std::numbers::pi);
}

TEST(Box, InvalidBoxesAreRefusedWithTheirRow) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  std::vector<Box> boxes(3);
  EXPECT_NO_THROW(require_valid(boxes, "test"));
  boxes[2].size.y() = 0;
  try {
    require_valid(boxes, "test");
    FAIL() << "a zero size was accepted";
  } catch (const arbox::InvalidArgument& error) {
    EXPECT_NE(std::string(error.what()).find("row 2"), std::string::npos) << error.what();
  }
  Box box;
  box.center.x() = nan;
  EXPECT_THROW(require_valid(box, "test"), arbox::InvalidArgument);
  box = {};
  box.rotation.w() = 1.1;
  EXPECT_THROW(require_valid(box, "test"), arbox::InvalidArgument);
}

}  // namespace
