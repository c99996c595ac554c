#include "arbox/io/internal/colored_rows.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "arbox/base/error.h"

namespace arbox::io::internal {
namespace {

constexpr std::size_t kColored = 6;

bool is_finite_row(const float* row) {
  return std::isfinite(row[0]) && std::isfinite(row[1]) && std::isfinite(row[2]);
}

/// What colours are to be divided by.
float color_scale(const std::vector<float>& values) {
  for (std::size_t i = 0; i < values.size(); i += kColored) {
    for (std::size_t c = 3; c < kColored; ++c) {
      if (values[i + c] > 1.0F) return 255.0F;
    }
  }
  return 1.0F;
}

}  // namespace

geometry::PointCloud colored_cloud(std::vector<float> values, std::size_t columns,
                                   std::vector<std::int32_t>* kept) {
  geometry::PointCloud cloud;
  if (columns == kColored) cloud.channels = {"r", "g", "b"};
  const std::size_t rows = values.size() / columns;
  std::size_t to = 0;
  if (kept != nullptr) kept->clear();
  for (std::size_t row = 0; row < rows; ++row) {
    if (!is_finite_row(values.data() + row * columns)) continue;
    if (to != row) {
      std::copy_n(values.begin() + static_cast<std::ptrdiff_t>(row * columns), columns,
                  values.begin() + static_cast<std::ptrdiff_t>(to * columns));
    }
    ++to;
    if (kept != nullptr) kept->push_back(static_cast<std::int32_t>(row));
  }
  values.resize(to * columns);
  if (columns == kColored) {
    const float scale = color_scale(values);
    for (std::size_t i = 0; i < values.size() && scale != 1.0F; i += kColored) {
      for (std::size_t c = 3; c < kColored; ++c) values[i + c] /= scale;
    }
  }
  cloud.values = std::move(values);
  return cloud;
}

geometry::PointCloud colored_cloud(const NpyArray& rows, const std::string& name,
                                   std::vector<std::int32_t>* kept) {
  const auto& shape = rows.shape();
  if (shape.size() != 2 || (shape[1] != 3 && shape[1] != kColored)) {
    std::string came;
    for (const std::size_t size : shape) came += (came.empty() ? "" : " x ") + std::to_string(size);
    throw FormatError(name + ": expected rows x y z r g b (N x 6), got an array of " +
                      (came.empty() ? "one number" : came));
  }
  return colored_cloud(rows.values<float>(), shape[1], kept);
}

std::vector<float> colored_rows(const geometry::PointCloud& cloud, float scale) {
  std::array<std::size_t, 3> from{};
  const std::array<const char*, 3> names = {"r", "g", "b"};
  bool colored = true;
  for (std::size_t c = 0; c < 3; ++c) {
    const auto found = std::find(cloud.channels.begin(), cloud.channels.end(), names[c]);
    colored &= found != cloud.channels.end();
    from[c] = 3 + static_cast<std::size_t>(found - cloud.channels.begin());
  }
  std::vector<float> rows;
  rows.reserve(cloud.size() * kColored);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const float* point = cloud.values.data() + i * cloud.columns();
    rows.insert(rows.end(), point, point + 3);
    for (std::size_t c = 0; c < 3; ++c) rows.push_back(colored ? point[from[c]] * scale : 0.0F);
  }
  return rows;
}

}  // namespace arbox::io::internal
