#include "arbox/detectors/pv_rcnn/internal/box_rows.h"

#include <algorithm>
#include <cmath>

#include "arbox/detectors/pv_rcnn/box_coding.h"

namespace arbox::detectors::pv_rcnn::internal {
namespace {

// Beyond this a box is no object, and its overlaps would overflow.
constexpr float kLargestNumber = 1e6f;

bool usable(const float* row) {
  const bool finite =
      std::all_of(row, row + kBoxNumbers, [](float v) { return std::abs(v) <= kLargestNumber; });
  return finite && std::all_of(row + 3, row + 6, [](float size) { return size > 0; });
}

}  // namespace

UsableBoxes usable_boxes(const at::Tensor& boxes) {
  const at::Tensor table = boxes.to(at::kFloat).contiguous();
  const float* row = table.data_ptr<float>();
  UsableBoxes result;
  for (std::int64_t i = 0; i < table.size(0); ++i, row += kBoxNumbers) {
    if (!usable(row)) {
      ++result.dropped;
      continue;
    }
    result.boxes.push_back(
        geometry::make_yaw_box({row[0], row[1], row[2]}, {row[3], row[4], row[5]}, row[6]));
    result.rows.push_back(i);
  }
  return result;
}

}  // namespace arbox::detectors::pv_rcnn::internal
