#include "arbox/heads/fit_ranges.h"

#include <ATen/TensorOperators.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "arbox/base/error.h"
#include "arbox/geometry/overlap.h"
#include "arbox/heads/box_tensor.h"
#include "arbox/heads/quantizer.h"

namespace arbox::heads {
namespace {

using at::Tensor;

/// A range far wider than any value, in which encode() is at home: it never clamps.
std::shared_ptr<const BoxCodec> unbounded(CodecOptions options) {
  options.size_low = options.center_low = -1e6;
  options.size_high = options.center_high = 1e6;
  return make_codec(options);
}

/// Components of sizes and of centres, sorted.
struct Values {
  std::vector<double> sizes, centers;
};

Values sorted_values(const Tensor& boxes, const References& references,
                     const CodecOptions& options) {
  const auto codec = unbounded(options);
  const Tensor rows = codec->encode(boxes, references).to(at::kDouble).contiguous();
  const auto width = rows.size(1);
  const auto of_size = codec->size_components();
  Values values;
  for (std::int64_t i = 0; i < width; ++i) {
    const std::string& name = codec->components()[i].name;
    const bool center = name == "x" || name == "y" || name == "z";
    const bool size = std::find(of_size.begin(), of_size.end(), i) != of_size.end();
    if (!center && !size) continue;
    std::vector<double>& into = size ? values.sizes : values.centers;
    for (std::int64_t n = 0; n < rows.size(0); ++n) {
      into.push_back(rows.data_ptr<double>()[n * width + i]);
    }
  }
  std::sort(values.sizes.begin(), values.sizes.end());
  std::sort(values.centers.begin(), values.centers.end());
  return values;
}

/// The range that leaves `outside` of the values at each end, wider by `margin` of itself.
std::array<double, 2> range_of(const std::vector<double>& sorted, double outside, double margin) {
  const auto skipped = static_cast<std::size_t>(outside * static_cast<double>(sorted.size()));
  const double low = sorted[skipped], high = sorted[sorted.size() - 1 - skipped];
  const double width = std::max(high - low, 1e-3);
  // A power of ten is exact only above one: 282 / 1000 is 0.282, 282 * 0.001 is not.
  const double digits = std::pow(10.0, std::max(0.0, 2.0 - std::floor(std::log10(width))));
  return {std::floor((low - margin * width) * digits) / digits,
          std::ceil((high + margin * width) * digits) / digits};
}

CodecOptions with_ranges(CodecOptions options, const Values& values, double outside,
                         double margin) {
  const auto size = range_of(values.sizes, outside, margin);
  const auto center = range_of(values.centers, outside, margin);
  options.size_low = size[0];
  options.size_high = size[1];
  options.center_low = center[0];
  options.center_high = center[1];
  return options;
}

void require_rows(std::size_t boxes, const References& references) {
  if (boxes == 0 || references.count() != static_cast<std::int64_t>(boxes)) {
    throw InvalidArgument("fit_ranges: expected at least one box and a reference for each, got " +
                          std::to_string(boxes) + " boxes and " +
                          std::to_string(references.count()) + " references");
  }
}

}  // namespace

RangeFit evaluate_ranges(std::span<const geometry::Box> boxes, const References& references,
                         const CodecOptions& options, const RangeGoal& goal) {
  require_rows(boxes.size(), references);
  const auto codec = make_codec(options);
  const References frame = references.detached(at::kDouble);
  const Tensor values = codec->encode(to_tensor(boxes, at::kDouble), frame);
  const Tensor bins = quantize(values, codec->components());
  const Tensor back =
      codec->decode(dequantize(bins, codec->components()).to(at::kDouble).unsqueeze(1), frame);
  Tensor rows = back.select(1, 0).contiguous();
  rows.slice(1, 3, 6).clamp_(1e-6);  // the lowest bin of a size may be zero
  RangeFit fit;
  fit.codec = options;
  fit.mean_iou = geometry::overlap_pairs(boxes, to_boxes(rows)).mean();
  fit.overflow = overflows(values, codec->components()).to(at::kDouble).mean().item<double>();
  fit.reached = fit.mean_iou >= goal.mean_iou && fit.overflow < goal.overflow;
  return fit;
}

RangeFit fit_ranges(std::span<const geometry::Box> boxes, const References& references,
                    const CodecOptions& options, const RangeGoal& goal) {
  require_rows(boxes.size(), references);
  struct Try {
    double outside, margin;
  };
  constexpr std::array<Try, 6> kTries = {Try{0.0, 0.01}, Try{0.0, 0.0}, Try{0.05, 0.0},
                                         Try{0.15, 0.0}, Try{0.3, 0.0}, Try{0.48, 0.0}};
  const References frame = references.detached(at::kDouble);
  const Values values = sorted_values(to_tensor(boxes, at::kDouble), frame, options);
  RangeFit best;
  for (const auto& [outside, margin] : kTries) {
    const RangeFit fit = evaluate_ranges(
        boxes, frame, with_ranges(options, values, outside * goal.overflow, margin), goal);
    if (fit.reached) return fit;
    if (fit.overflow < goal.overflow && fit.mean_iou > best.mean_iou) best = fit;
  }
  return best;
}

}  // namespace arbox::heads
