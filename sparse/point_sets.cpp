#include "arbox/sparse/point_sets.h"

#include <ATen/TensorOperators.h>
#include <ATen/ops/arange.h>
#include <ATen/ops/empty.h>
#include <ATen/ops/full.h>
#include <ATen/ops/stack.h>

#include <algorithm>
#include <numeric>
#include <sstream>
#include <string>
#include <vector>

#include "arbox/base/error.h"

namespace arbox::sparse {
namespace {

void require_shape(const at::Tensor& tensor, std::int64_t dimensions, std::int64_t last,
                   const char* expected) {
  if (tensor.dim() == dimensions && (last < 0 || tensor.size(-1) == last)) return;
  std::ostringstream text;
  text << expected << ", got " << tensor.sizes();
  throw InvalidArgument(text.str());
}

at::Tensor packed_points(const at::Tensor& points, const char* where) {
  require_shape(points, 2, 3, (std::string(where) + ": expected points (N, 3)").c_str());
  return points.detach().to(at::kCPU, at::kFloat).contiguous();
}

std::span<const float> contiguous_numbers(const at::Tensor& packed) {
  return {packed.data_ptr<float>(), static_cast<std::size_t>(packed.numel())};
}

at::Tensor to_tensor(const std::vector<std::int32_t>& index, const at::Device& device) {
  at::Tensor result = at::empty({static_cast<std::int64_t>(index.size())}, at::kLong);
  std::copy(index.begin(), index.end(), result.data_ptr<std::int64_t>());
  return result.to(device);
}

void require_counts(std::span<const std::int64_t> counts, std::int64_t total, const char* what) {
  const bool negative = std::any_of(counts.begin(), counts.end(), [](auto c) { return c < 0; });
  if (!negative && std::accumulate(counts.begin(), counts.end(), std::int64_t{0}) == total) return;
  throw InvalidArgument(std::string("ball_query: the ") + what + " counts do not sum to " +
                        std::to_string(total));
}

}  // namespace

at::Tensor furthest_points(const at::Tensor& points, std::int64_t count) {
  const at::Tensor packed = packed_points(points, "furthest_points");
  return to_tensor(furthest_points(contiguous_numbers(packed), count), points.device());
}

at::Tensor ball_query(const at::Tensor& points, const at::Tensor& centres, const BallQuery& query,
                      std::span<const std::int64_t> point_counts,
                      std::span<const std::int64_t> centre_counts) {
  const at::Tensor from = packed_points(points, "ball_query");
  const at::Tensor around = packed_points(centres, "ball_query (centres)");
  const std::int64_t all_points[] = {from.size(0)}, all_centres[] = {around.size(0)};
  if (point_counts.empty() && centre_counts.empty()) {
    point_counts = all_points;
    centre_counts = all_centres;
  }
  require_counts(point_counts, from.size(0), "point");
  require_counts(centre_counts, around.size(0), "centre");
  if (point_counts.size() != centre_counts.size()) {
    throw InvalidArgument("ball_query: point and centre counts name different numbers of scenes");
  }
  at::Tensor result = at::full({around.size(0), query.samples}, -1, at::kLong);
  auto* to = result.data_ptr<std::int64_t>();
  std::int64_t first_point = 0, first_centre = 0;
  for (std::size_t scene = 0; scene < point_counts.size(); ++scene) {
    const auto found = ball_query(
        contiguous_numbers(from).subspan(3 * first_point, 3 * point_counts[scene]),
        contiguous_numbers(around).subspan(3 * first_centre, 3 * centre_counts[scene]), query);
    for (const std::int32_t index : found) *to++ = index < 0 ? -1 : index + first_point;
    first_point += point_counts[scene];
    first_centre += centre_counts[scene];
  }
  return result.to(points.device());
}

at::Tensor group(const at::Tensor& features, const at::Tensor& index) {
  require_shape(features, 2, -1, "group: expected features (N, C)");
  require_shape(index, 2, -1, "group: expected an index (M, S)");
  if (features.size(0) == 0) {
    return at::full({index.size(0), index.size(1), features.size(1)}, 0, features.options());
  }
  const at::Tensor present = (index >= 0).to(features.scalar_type()).unsqueeze(-1);
  return features.index_select(0, index.clamp_min(0).flatten())
             .view({index.size(0), index.size(1), features.size(1)}) *
         present;
}

at::Tensor sample_birds_eye(const at::Tensor& map, const at::Tensor& places) {
  require_shape(map, 4, -1, "sample_birds_eye: expected a map (B, C, H, W)");
  require_shape(places, 2, 3, "sample_birds_eye: expected places (M, 3)");
  const std::int64_t height = map.size(2), width = map.size(3);
  const at::Tensor rows = map.permute({0, 2, 3, 1}).reshape({-1, map.size(1)});
  const at::Tensor batch = places.select(1, 0).to(at::kLong);
  if (batch.numel() > 0 &&
      (batch.min().item<std::int64_t>() < 0 || batch.max().item<std::int64_t>() >= map.size(0))) {
    throw InvalidArgument("sample_birds_eye: a place names a scene that the map does not have");
  }
  const at::Tensor x = places.select(1, 1).to(map.scalar_type());
  const at::Tensor y = places.select(1, 2).to(map.scalar_type());
  const at::Tensor x0 = x.floor().clamp(0, width - 1), x1 = (x.floor() + 1).clamp(0, width - 1);
  const at::Tensor y0 = y.floor().clamp(0, height - 1), y1 = (y.floor() + 1).clamp(0, height - 1);
  const auto corner = [&](const at::Tensor& cx, const at::Tensor& cy, const at::Tensor& weight) {
    const at::Tensor cell = (batch * height + cy.to(at::kLong)) * width + cx.to(at::kLong);
    return rows.index_select(0, cell) * weight.unsqueeze(1);
  };
  return corner(x0, y0, (x1 - x) * (y1 - y)) + corner(x0, y1, (x1 - x) * (y - y0)) +
         corner(x1, y0, (x - x0) * (y1 - y)) + corner(x1, y1, (x - x0) * (y - y0));
}

at::Tensor roi_grid_points(const at::Tensor& boxes, std::int64_t cells) {
  require_shape(boxes, 2, 10, "roi_grid_points: expected boxes (R, 10)");
  if (cells < 1) throw InvalidArgument("roi_grid_points: expected at least one cell an axis");
  const at::Tensor place = (at::arange(cells, boxes.options()) + 0.5) / cells - 0.5;
  const at::Tensor unit = at::stack({place.view({cells, 1, 1}).expand({cells, cells, cells}),
                                     place.view({1, cells, 1}).expand({cells, cells, cells}),
                                     place.view({1, 1, cells}).expand({cells, cells, cells})},
                                    -1)
                              .reshape({1, cells * cells * cells, 3});
  const at::Tensor local = unit * boxes.slice(1, 3, 6).unsqueeze(1);
  const at::Tensor q = boxes.slice(1, 6, 10) / boxes.slice(1, 6, 10).norm(2, 1, true);
  const at::Tensor w = q.select(1, 0), x = q.select(1, 1), y = q.select(1, 2), z = q.select(1, 3);
  const at::Tensor turn =
      at::stack({1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y),
                 2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x),
                 2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)},
                1)
          .view({-1, 3, 3});
  return local.matmul(turn.transpose(1, 2)) + boxes.slice(1, 0, 3).unsqueeze(1);
}

at::Tensor points_in_boxes(const at::Tensor& points, const at::Tensor& boxes, double margin) {
  require_shape(boxes, 2, 10, "points_in_boxes: expected boxes (M, 10)");
  const at::Tensor packed = packed_points(points, "points_in_boxes");
  const at::Tensor table = boxes.detach().to(at::kCPU, at::kDouble).contiguous();
  const std::span<const double> rows{table.data_ptr<double>(),
                                     static_cast<std::size_t>(table.numel())};
  return to_tensor(box_of_points(contiguous_numbers(packed), rows, margin), points.device());
}

}  // namespace arbox::sparse
