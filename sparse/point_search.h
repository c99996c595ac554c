#pragma once

#include <cstdint>
#include <span>
#include <vector>

/// \file
/// Choosing and finding points, without tensors. Points are packed float32 rows x y z in metres;
/// coordinates must be finite (InvalidArgument otherwise). point_sets.h wraps these for tensors.

namespace arbox::sparse {

/// Furthest point sampling: `count` indices, the first 0, each next one the point furthest from
/// all chosen so far; ties go to the lowest index. With fewer points than `count` the choice of all
/// N points is repeated from its start, as PV-RCNN does. No point gives no index.
/// O(N count), one thread, the same at every SIMD level.
std::vector<std::int32_t> furthest_points(std::span<const float> points, std::int64_t count);

/// Which of the points inside a ball are taken when there are more than asked.
enum class BallRule {
  kFirst,    ///< lowest indices (PV-RCNN, PointNet++)
  kNearest,  ///< smallest distances, then lowest indices
};

struct BallQuery {
  float radius = 1;           ///< metres; a point is inside if its squared distance is < radius^2
  std::int32_t samples = 16;  ///< indices for each centre
  BallRule rule = BallRule::kFirst;
};

/// For each centre `samples` indices of points in the ball, row after row. Fewer hits are padded
/// with the first hit; a centre without any gets -1 throughout. Hits of kFirst ascend by index,
/// those of kNearest by distance. Uses a hash-free grid of cells one radius wide:
/// O(N log N + hits). threads = 0 means default_threads(); the result does not depend on it.
std::vector<std::int32_t> ball_query(std::span<const float> points, std::span<const float> centres,
                                     const BallQuery& query, int threads = 0);

/// For each point the lowest row of `boxes` (10 numbers: x y z l w h qw qx qy qz, float64) that
/// holds it, faces included, grown by `margin` metres on all sides; -1 for none. O(N boxes).
std::vector<std::int32_t> box_of_points(std::span<const float> points,
                                        std::span<const double> boxes, double margin = 0,
                                        int threads = 0);

}  // namespace arbox::sparse
