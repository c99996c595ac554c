#include "arbox/heads/quartile_codec.h"

#include <ATen/TensorOperators.h>
#include <ATen/ops/arange.h>
#include <ATen/ops/argmax.h>
#include <ATen/ops/cat.h>
#include <ATen/ops/clamp.h>
#include <ATen/ops/empty.h>
#include <ATen/ops/gather.h>
#include <ATen/ops/ones.h>

#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include "arbox/base/error.h"
#include "arbox/geometry/rotation.h"
#include "arbox/heads/box_tensor.h"
#include "arbox/heads/internal/rotation_tensor.h"

namespace arbox::heads {
namespace {

using at::Tensor;

constexpr std::int64_t kOrders = 6, kSigns = 4;

/// The 24 rotations of a box frame, those with the same order of axes together (the identity's
/// first), and the order of sizes that goes with each.
struct FrameTable {
  Tensor rotations;  // (24, 4)
  Tensor orders;     // (24, 3) int64: which own size comes first, second, third
};

FrameTable make_table() {
  const auto symmetries = geometry::symmetry_rotations(geometry::BoxSymmetry::kFrame);
  std::vector<std::pair<std::array<std::int64_t, 3>, geometry::Quaternion>> rows;
  for (const geometry::Quaternion& rotation : symmetries) {
    const Eigen::Matrix3d matrix = rotation.toRotationMatrix();
    std::array<std::int64_t, 3> order{};
    for (int axis = 0; axis < 3; ++axis) {
      matrix.col(axis).cwiseAbs().maxCoeff(&order[static_cast<std::size_t>(axis)]);
    }
    rows.emplace_back(order, rotation);
  }
  std::stable_sort(rows.begin(), rows.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  FrameTable table{at::empty({kOrders * kSigns, 4}, at::kDouble),
                   at::empty({kOrders * kSigns, 3}, at::kLong)};
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const auto& [order, rotation] = rows[i];
    double* quaternion = table.rotations.data_ptr<double>() + 4 * i;
    quaternion[0] = rotation.w();
    quaternion[1] = rotation.x();
    quaternion[2] = rotation.y();
    quaternion[3] = rotation.z();
    std::copy(order.begin(), order.end(), table.orders.data_ptr<std::int64_t>() + 3 * i);
  }
  return table;
}

const FrameTable& frame_table() {
  static const FrameTable table = make_table();
  return table;
}

/// Index (N, 6) into the 24 of the canonical signs of each order.
Tensor canonical_signs(const Tensor& rotations) {
  const Tensor w = rotations.select(-1, 0), x = rotations.select(-1, 1),
               y = rotations.select(-1, 2), z = rotations.select(-1, 3);
  // Rounding must not choose where an axis lies in the plane (boxes that stand upright).
  constexpr double kTie = 1e-6;
  const Tensor first = (x * y + w * z) > kTie;   // R[1][0] / 2
  const Tensor second = (y * z + w * x) > kTie;  // R[2][1] / 2
  const Tensor score =
      (2 * first.to(at::kLong) + second.to(at::kLong)).view({rotations.size(0), kOrders, kSigns});
  const Tensor best = at::argmax(kSigns * score - at::arange(kSigns, at::kLong), -1);
  Tensor start = at::empty({kOrders}, at::kLong);
  for (std::int64_t i = 0; i < kOrders; ++i) start.data_ptr<std::int64_t>()[i] = i * kSigns;
  return best + start;
}

/// Where the bins of beta end if pi / 2 is one of them.
double beta_end(int bins) {
  const bool between = bins % 2 == 0 && bins > 2;
  return between ? std::numbers::pi * (bins - 1) / (bins - 2) : std::numbers::pi;
}

Tensor rows_of(const Tensor& tensor, const Tensor& index) {
  return at::gather(tensor, 1,
                    index.unsqueeze(-1).expand({index.size(0), index.size(1), tensor.size(2)}));
}

}  // namespace

QuartileCodec::QuartileCodec(QuartileCodecOptions options) : options_(std::move(options)) {
  if (options_.equivalents != "canonical" && options_.equivalents != "all" &&
      options_.equivalents != "one") {
    throw ConfigError("codec equivalents: expected canonical, all or one, got '" +
                      options_.equivalents + "'");
  }
  if (options_.bins < 2 || options_.size_low >= options_.size_high ||
      options_.center_low >= options_.center_high) {
    throw ConfigError("codec: expected at least 2 bins and ranges with low < high");
  }
  if (!size_first() && options_.order != "center_size_rotation") {
    throw ConfigError("codec order: expected size_center_rotation or center_size_rotation, got '" +
                      options_.order + "'");
  }
  const auto add_sizes = [this] {
    for (const char* name : {"length", "width", "height"}) {
      components_.push_back({name, options_.size_low, options_.size_high, options_.bins, false});
    }
  };
  if (size_first()) add_sizes();
  for (const char* name : {"x", "y", "z"}) {
    components_.push_back({name, options_.center_low, options_.center_high, options_.bins, false});
  }
  if (!size_first()) add_sizes();
  constexpr double pi = std::numbers::pi;
  components_.push_back({"alpha", 0.0, 2 * pi, options_.bins, true});
  components_.push_back(
      {"beta", 0.0, options_.beta_high.value_or(beta_end(options_.bins)), options_.bins, false});
  components_.push_back({"gamma", 0.0, 2 * pi, options_.bins, true});
}

ComponentSet QuartileCodec::equivalents(const Tensor& boxes, const References& references) const {
  require_boxes(boxes, "equivalents");
  references.require_valid("equivalents");
  const FrameTable& table = frame_table();
  const Tensor back = internal::quaternion_conjugate(references.rotation);
  const Tensor scale = references.size.slice(-1, 0, 1);
  const Tensor center = internal::rotate(back, boxes.slice(-1, 0, 3) - references.origin) / scale;
  const Tensor turn = internal::quaternion_product(back, boxes.slice(-1, 6, 10)).unsqueeze(1);
  Tensor rotations =
      internal::quaternion_product(turn, table.rotations.to(boxes.scalar_type()).unsqueeze(0));
  const std::int64_t count = boxes.size(0);
  Tensor sizes = at::gather((boxes.slice(-1, 3, 6) / scale).unsqueeze(1).expand({count, 24, 3}), 2,
                            table.orders.unsqueeze(0).expand({count, 24, 3}));
  if (options_.equivalents != "all") {
    Tensor index = canonical_signs(rotations.detach());
    if (options_.equivalents == "one") index = index.slice(1, 0, 1);
    rotations = rows_of(rotations, index);
    sizes = rows_of(sizes, index);
  }
  const std::int64_t vectors = sizes.size(1);
  const Tensor centers = center.unsqueeze(1).expand({count, vectors, 3});
  return {at::cat({size_first() ? sizes : centers, size_first() ? centers : sizes,
                   internal::zyz_of(rotations)},
                  -1),
          at::ones({count, vectors}, boxes.options().dtype(at::kBool))};
}

Tensor QuartileCodec::encode(const Tensor& boxes, const References& references) const {
  QuartileCodecOptions one = options_;
  one.equivalents = "one";
  return QuartileCodec(one).equivalents(boxes, references).values.select(1, 0);
}

Tensor QuartileCodec::decode(const Tensor& components, const References& references) const {
  references.require_valid("decode");
  const Tensor scale = references.size.slice(-1, 0, 1).unsqueeze(1);
  const Tensor turn = references.rotation.unsqueeze(1);
  const Tensor first = components.slice(-1, 0, 3), second = components.slice(-1, 3, 6);
  const Tensor center = references.origin.unsqueeze(1) +
                        internal::rotate(turn, (size_first() ? second : first) * scale);
  return at::cat(
      {center, at::clamp((size_first() ? first : second) * scale, kLeastDecodedSize),
       internal::quaternion_product(turn, internal::zyz_quaternion(components.slice(-1, 6, 9)))},
      -1);
}

std::vector<int> QuartileCodec::size_components() const {
  return size_first() ? std::vector{0, 1, 2} : std::vector{3, 4, 5};
}

Tensor QuartileCodec::encode_sizes(const Tensor& sizes, const References& references) const {
  const Tensor scale = references.size.slice(-1, 0, 1);
  return sizes / (sizes.dim() > 2 ? scale.unsqueeze(1) : scale);
}

}  // namespace arbox::heads
