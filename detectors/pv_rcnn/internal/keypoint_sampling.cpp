#include "arbox/detectors/pv_rcnn/internal/keypoint_sampling.h"

#include <ATen/ops/empty.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <unordered_map>

#include "arbox/detectors/pv_rcnn/box_coding.h"
#include "arbox/sparse/point_search.h"

namespace arbox::detectors::pv_rcnn::internal {
namespace {

constexpr std::size_t kPointColumns = 4;
constexpr float kCell = 2.0f;

struct Ball {
  std::array<float, 3> centre;
  float square;
};

/// Balls by the cells of a grid, seen from above, that they reach.
class BallGrid {
 public:
  void add(const Ball& ball) {
    const float radius = std::sqrt(ball.square);
    for (int x = cell(ball.centre[0] - radius); x <= cell(ball.centre[0] + radius); ++x) {
      for (int y = cell(ball.centre[1] - radius); y <= cell(ball.centre[1] + radius); ++y) {
        balls_[key(x, y)].push_back(ball);
      }
    }
  }

  bool holds(const float* p) const {
    const auto found = balls_.find(key(cell(p[0]), cell(p[1])));
    if (found == balls_.end()) return false;
    return std::any_of(found->second.begin(), found->second.end(), [p](const Ball& ball) {
      const float x = p[0] - ball.centre[0], y = p[1] - ball.centre[1], z = p[2] - ball.centre[2];
      return x * x + y * y + z * z < ball.square;
    });
  }

 private:
  static int cell(float v) { return static_cast<int>(std::floor(v / kCell)); }
  static std::int64_t key(int x, int y) { return (std::int64_t{x} << 32) + y; }

  std::unordered_map<std::int64_t, std::vector<Ball>> balls_;
};

std::vector<float> positions(std::span<const float> points) {
  std::vector<float> result;
  result.reserve(points.size() / kPointColumns * 3);
  for (std::size_t i = 0; i < points.size(); i += kPointColumns) {
    result.insert(result.end(), points.begin() + i, points.begin() + i + 3);
  }
  return result;
}

}  // namespace

std::vector<float> points_near(std::span<const float> points, std::span<const float> regions,
                               double margin) {
  BallGrid grid;
  for (std::size_t i = 0; i < regions.size(); i += kBoxNumbers) {
    const float* box = regions.data() + i;
    const double radius = 0.5 * std::hypot(box[3], box[4], box[5]) + margin;
    grid.add({{box[0], box[1], box[2]}, static_cast<float>(radius * radius)});
  }
  std::vector<float> result;
  for (std::size_t i = 0; i < points.size(); i += kPointColumns) {
    const float* p = points.data() + i;
    if (grid.holds(p)) result.insert(result.end(), p, p + 3);
  }
  return result;
}

ChosenPoints choose_keypoints(const at::Tensor& points, std::span<const std::int64_t> point_counts,
                              const at::Tensor& regions, const at::Tensor& scene,
                              const KeypointOptions& options) {
  const at::Tensor rows = points.contiguous();
  const at::Tensor boxes = regions.detach().to(at::kFloat).contiguous();
  const at::Tensor scenes = scene.contiguous();
  const std::span<const float> all{rows.data_ptr<float>(), static_cast<std::size_t>(rows.numel())};
  const float* box = boxes.data_ptr<float>();
  const auto* of_box = scenes.data_ptr<std::int64_t>();
  const auto* end_of_boxes = of_box + scenes.numel();
  std::vector<float> chosen;
  ChosenPoints result;
  std::size_t first = 0;
  for (std::size_t scan = 0; scan < point_counts.size(); ++scan) {
    const auto count = static_cast<std::size_t>(point_counts[scan]);
    const auto own = all.subspan(kPointColumns * first, kPointColumns * count);
    first += count;
    const auto [begin, end] =
        std::equal_range(of_box, end_of_boxes, static_cast<std::int64_t>(scan));
    const std::vector<float> from =
        options.around == "scan"
            ? positions(own)
            : points_near(own,
                          {box + kBoxNumbers * (begin - of_box),
                           static_cast<std::size_t>(kBoxNumbers * (end - begin))},
                          options.margin);
    const auto indices = sparse::furthest_points(from, options.count);
    for (const std::int32_t i : indices) {
      chosen.insert(chosen.end(), from.begin() + 3 * i, from.begin() + 3 * i + 3);
    }
    result.counts.push_back(static_cast<std::int64_t>(indices.size()));
  }
  result.points = at::empty({static_cast<std::int64_t>(chosen.size() / 3), 3}, at::kFloat);
  std::copy(chosen.begin(), chosen.end(), result.points.data_ptr<float>());
  return result;
}

}  // namespace arbox::detectors::pv_rcnn::internal
