#include "arbox/heads/box_tensor.h"

#include <ATen/ops/zeros.h>
#include <gtest/gtest.h>

#include <cmath>

#include "arbox/base/error.h"

namespace {

using namespace arbox;

TEST(BoxTensor, BoxesRoundTripInDouble) {
  const std::vector<geometry::Box> boxes = {geometry::make_yaw_box({1e6, -2, 3}, {4, 2, 1}, 0.3),
                                            {}};
  const auto back = heads::to_boxes(heads::to_tensor(boxes, at::kDouble));
  ASSERT_EQ(back.size(), 2u);
  EXPECT_EQ(back[0].center, boxes[0].center);
  EXPECT_EQ(back[0].size, boxes[0].size);
  EXPECT_NEAR(geometry::yaw(back[0]), 0.3, 1e-15);
}

TEST(BoxTensor, NoBoxesGiveZeroRows) {
  const at::Tensor tensor = heads::to_tensor({});
  EXPECT_EQ(tensor.size(0), 0);
  EXPECT_EQ(tensor.size(1), heads::kBoxColumns);
  EXPECT_TRUE(heads::to_boxes(tensor).empty());
}

TEST(BoxTensor, BadRowsAndShapesAreRefused) {
  const std::vector<geometry::Box> boxes(3);
  at::Tensor tensor = heads::to_tensor(boxes);
  tensor[1][4] = std::nan("");
  EXPECT_THROW(heads::to_boxes(tensor), NumericalError);
  EXPECT_THROW(heads::to_boxes(at::zeros({2, 7})), InvalidArgument);
  EXPECT_THROW(heads::to_boxes(at::zeros({2, 2, 10})), InvalidArgument);
}

}  // namespace
