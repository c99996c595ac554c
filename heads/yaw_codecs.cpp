#include "arbox/heads/yaw_codecs.h"

#include <ATen/TensorOperators.h>
#include <ATen/ops/cat.h>
#include <ATen/ops/clamp.h>
#include <ATen/ops/exp.h>
#include <ATen/ops/log.h>
#include <ATen/ops/ones.h>
#include <ATen/ops/sqrt.h>
#include <ATen/ops/stack.h>

#include <numbers>
#include <utility>

#include "arbox/base/error.h"
#include "arbox/heads/box_tensor.h"
#include "arbox/heads/internal/rotation_tensor.h"

namespace arbox::heads {
namespace {

using at::Tensor;

constexpr double kPi = std::numbers::pi;
constexpr double kLeastReferenceSize = 1e-5;

/// (N, 3) or (N, 4) -> (N, 1, .) where `values` has a dimension of K vectors.
Tensor for_rows(const Tensor& reference, const Tensor& values) {
  return values.dim() > reference.dim() ? reference.unsqueeze(1) : reference;
}

}  // namespace

YawCodec::YawCodec(YawCodecOptions options, bool with_yaw, double yaw_low)
    : options_(std::move(options)),
      with_yaw_(with_yaw),
      yaw_low_(yaw_low),
      yaw_period_(options_.full_turn ? 2 * kPi : kPi),
      size_first_(options_.order == "size_center_rotation") {
  if (!size_first_ && options_.order != "center_size_rotation") {
    throw ConfigError("codec order: expected size_center_rotation or center_size_rotation, got '" +
                      options_.order + "'");
  }
  if (options_.bins < 2 || options_.size_low >= options_.size_high ||
      options_.center_low >= options_.center_high) {
    throw ConfigError("codec: expected at least 2 bins and ranges with low < high");
  }
  const auto add = [&](const char* name, double low, double high, bool circular) {
    components_.push_back({name, low, high, options_.bins, circular});
  };
  const auto add_sizes = [&] {
    for (const char* name : {"length", "width", "height"}) {
      add(name, options_.size_low, options_.size_high, false);
    }
  };
  if (size_first_) add_sizes();
  for (const char* name : {"x", "y", "z"}) {
    add(name, options_.center_low, options_.center_high, false);
  }
  if (!size_first_) add_sizes();
  if (with_yaw_) add("yaw", yaw_low_, yaw_low_ + yaw_period_, true);
}

Tensor YawCodec::join(const Tensor& size, const Tensor& center, const Tensor& yaw) const {
  std::vector<Tensor> parts = {size_first_ ? size : center, size_first_ ? center : size};
  if (with_yaw_) parts.push_back(internal::wrap(yaw, yaw_low_, yaw_period_).unsqueeze(-1));
  return at::cat(parts, -1);
}

Tensor YawCodec::encode(const Tensor& boxes, const References& references) const {
  require_boxes(boxes, "encode");
  references.require_valid("encode");
  const Tensor back = internal::quaternion_conjugate(references.rotation);
  const Tensor local = internal::rotate(back, boxes.slice(-1, 0, 3) - references.origin);
  const Tensor yaw =
      internal::yaw_of(boxes.slice(-1, 6, 10)) - internal::yaw_of(references.rotation);
  return join(encode_size(boxes.slice(-1, 3, 6), references), encode_center(local, references),
              yaw);
}

Tensor YawCodec::decode(const Tensor& components, const References& references) const {
  references.require_valid("decode");
  const std::int64_t size_at = size_first_ ? 0 : 3, center_at = 3 - size_at;
  const Tensor turn = references.rotation.unsqueeze(1);
  const Tensor local = decode_center(components.slice(-1, center_at, center_at + 3), references);
  const Tensor center = references.origin.unsqueeze(1) + internal::rotate(turn, local);
  const Tensor size = at::clamp(decode_size(components.slice(-1, size_at, size_at + 3), references),
                                kLeastDecodedSize);
  Tensor yaw = internal::yaw_of(references.rotation).unsqueeze(1);
  yaw = with_yaw_ ? yaw + components.select(-1, 6) : yaw.expand(components.sizes().slice(0, 2));
  return at::cat({center, size, internal::yaw_quaternion(yaw)}, -1);
}

ComponentSet YawCodec::equivalents(const Tensor& boxes, const References& references) const {
  std::vector<Tensor> vectors = {encode(boxes, references)};
  const auto turned = [&](const Tensor& from, double angle) {
    const Tensor turn = internal::yaw_quaternion(at::ones({1}, boxes.options()) * angle);
    return at::cat(
        {from.slice(-1, 0, 6), internal::quaternion_product(from.slice(-1, 6, 10), turn)}, -1);
  };
  const bool half = options_.half_turn_equivalent && options_.full_turn && with_yaw_;
  if (half) vectors.push_back(encode(turned(boxes, kPi), references));
  if (options_.quarter_turn_equivalent && with_yaw_) {
    const Tensor size =
        at::stack({boxes.select(-1, 4), boxes.select(-1, 3), boxes.select(-1, 5)}, -1);
    const Tensor swapped = at::cat({boxes.slice(-1, 0, 3), size, boxes.slice(-1, 6, 10)}, -1);
    vectors.push_back(encode(turned(swapped, 0.5 * kPi), references));
    if (half) vectors.push_back(encode(turned(swapped, -0.5 * kPi), references));
  }
  const Tensor values = at::stack(vectors, 1);
  return {values, at::ones({values.size(0), values.size(1)}, boxes.options().dtype(at::kBool))};
}

std::vector<int> YawCodec::size_components() const {
  return size_first_ ? std::vector{0, 1, 2} : std::vector{3, 4, 5};
}

Tensor YawCodec::encode_sizes(const Tensor& sizes, const References& references) const {
  return encode_size(sizes, references);
}

ResidualCodec::ResidualCodec(YawCodecOptions options)
    : YawCodec(options, true, options.full_turn ? -kPi : -0.5 * kPi) {}

namespace {

/// (d, d, h) of the regions of interest.
Tensor center_scale(const References& references) {
  const Tensor size = at::clamp(references.size, kLeastReferenceSize);
  const Tensor diagonal = at::sqrt(size.select(-1, 0).square() + size.select(-1, 1).square());
  return at::stack({diagonal, diagonal, size.select(-1, 2)}, -1);
}

Tensor scale_of(const References& references) { return references.size.slice(-1, 0, 1); }

}  // namespace

Tensor ResidualCodec::encode_center(const Tensor& local, const References& references) const {
  return local / for_rows(center_scale(references), local);
}
Tensor ResidualCodec::decode_center(const Tensor& values, const References& references) const {
  return values * for_rows(center_scale(references), values);
}
Tensor ResidualCodec::encode_size(const Tensor& sizes, const References& references) const {
  return at::log(at::clamp(sizes, kLeastReferenceSize) /
                 for_rows(at::clamp(references.size, kLeastReferenceSize), sizes));
}
Tensor ResidualCodec::decode_size(const Tensor& values, const References& references) const {
  return at::exp(values) * for_rows(at::clamp(references.size, kLeastReferenceSize), values);
}

ScaledCodec::ScaledCodec(YawCodecOptions options, bool with_yaw)
    : YawCodec(std::move(options), with_yaw, 0.0) {}

Tensor ScaledCodec::encode_center(const Tensor& local, const References& references) const {
  return local / for_rows(scale_of(references), local);
}
Tensor ScaledCodec::decode_center(const Tensor& values, const References& references) const {
  return values * for_rows(scale_of(references), values);
}
Tensor ScaledCodec::encode_size(const Tensor& sizes, const References& references) const {
  return sizes / for_rows(scale_of(references), sizes);
}
Tensor ScaledCodec::decode_size(const Tensor& values, const References& references) const {
  return values * for_rows(scale_of(references), values);
}

}  // namespace arbox::heads
