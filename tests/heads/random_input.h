#pragma once

#include <ATen/core/Tensor.h>
#include <ATen/ops/ones.h>
#include <ATen/ops/zeros.h>

#include <vector>

#include "arbox/base/random.h"
#include "arbox/heads/box_head.h"
#include "arbox/heads/box_tensor.h"

namespace arbox::testing {

/// (rows, columns) standard normal numbers that depend on the seed alone.
inline at::Tensor normal_rows(std::int64_t rows, std::int64_t columns, std::uint64_t seed,
                              at::ScalarType type = at::kFloat) {
  const RandomStream random(seed, 0, 0);
  at::Tensor result = at::zeros({rows, columns}, at::kDouble);
  for (std::int64_t i = 0; i < rows * columns; ++i) {
    result.data_ptr<double>()[i] = random.normal(static_cast<std::uint32_t>(i));
  }
  return result.to(type);
}

/// Objects with references of 3 to 5 m, and a box near each reference.
struct RandomObjects {
  heads::HeadInput input;
  at::Tensor boxes;  // (N, 10)
};

inline RandomObjects random_objects(const heads::HeadContext& context, std::int64_t count,
                                    std::uint64_t seed, at::ScalarType type = at::kFloat) {
  std::vector<geometry::Box> frames, boxes;
  for (std::int64_t i = 0; i < count; ++i) {
    const RandomStream random(seed, static_cast<std::uint64_t>(i), 1);
    const auto u = [&](std::uint32_t draw) { return random.uniform(draw); };
    const double edge = 3 + 2 * u(0);
    const bool upright = context.codec->upright();
    frames.push_back(geometry::make_yaw_box({10 * u(1), 10 * u(2), u(3)}, {edge, edge, edge},
                                            upright ? u(4) : 0.0));
    geometry::Box box = geometry::make_yaw_box(
        frames.back().center + Eigen::Vector3d(u(5), u(6), u(7)),
        edge * Eigen::Vector3d(0.7 + 0.3 * u(8), 0.9 + 0.3 * u(9), 0.8 + 0.3 * u(10)),
        geometry::yaw(frames.back()) + u(11));
    if (!upright) {
      box.rotation = geometry::Quaternion(random.normal(12), random.normal(13), random.normal(14),
                                          random.normal(15))
                         .normalized();
    }
    boxes.push_back(box);
  }
  const at::Tensor rows = heads::to_tensor(frames, type);
  RandomObjects result;
  result.input.features = normal_rows(count, context.features, seed + 1, type);
  result.input.references = {rows.slice(1, 0, 3), rows.slice(1, 6, 10), rows.slice(1, 3, 6)};
  if (context.condition > 0) {
    result.input.condition = normal_rows(count, context.condition, seed + 2, type);
  }
  result.boxes = heads::to_tensor(boxes, type);
  return result;
}

}  // namespace arbox::testing
