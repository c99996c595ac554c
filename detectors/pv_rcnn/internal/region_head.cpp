#include "arbox/detectors/pv_rcnn/internal/region_head.h"

#include <ATen/TensorOperators.h>

#include "arbox/base/error.h"
#include "arbox/detectors/pv_rcnn/box_coding.h"
#include "arbox/detectors/pv_rcnn/internal/scales.h"
#include "arbox/sparse/point_sets.h"

namespace arbox::detectors::pv_rcnn::internal {
namespace {

constexpr double kRegionResidualSpread = 0.001;

using Dropout = RowNetwork::Dropout;

enum Part : std::size_t { kShared, kConfidence, kResiduals };

std::vector<std::int64_t> counts_of(const at::Tensor& scene, std::size_t scans) {
  std::vector<std::int64_t> counts(scans, 0);
  const at::Tensor here = scene.contiguous();
  const auto* row = here.data_ptr<std::int64_t>();
  for (std::int64_t i = 0; i < here.numel(); ++i) {
    const bool in_order = row[i] >= 0 && row[i] < static_cast<std::int64_t>(scans) &&
                          (i == 0 || row[i] >= row[i - 1]);
    if (!in_order) {
      throw InvalidArgument("second_stage: region " + std::to_string(i) + " is of scan " +
                            std::to_string(row[i]) + ", expected rising numbers below " +
                            std::to_string(scans));
    }
    ++counts[row[i]];
  }
  return counts;
}

}  // namespace

RegionHead::RegionHead(const RegionOptions& options, std::int64_t keypoint_channels)
    : grid_(options.grid) {
  pooling_ = register_module(
      "roi_grid_pool_layer",
      std::make_shared<sparse::SetAbstraction>(keypoint_channels, scales(options.pooling)));
  const std::int64_t pooled = pooling_->out_channels() * grid_ * grid_ * grid_;
  const auto add = [&](const char* name, std::int64_t in, const std::vector<std::int64_t>& hidden,
                       std::int64_t out) {
    networks_.emplace_back(
        *add_child(*this, name),
        RowNetwork::Shape{.in = in,
                          .hidden = hidden,
                          .out = out,
                          .ones = 1,
                          .places = out == 0 ? Dropout::kBetween : Dropout::kAfterFirst,
                          .dropout = options.dropout});
  };
  add("shared_fc_layer", pooled, options.shared, 0);
  add("cls_layers", options.shared.back(), options.confidence, 1);
  add("reg_layers", options.shared.back(), options.residuals, kBoxNumbers);
  networks_[kConfidence].last_bias().detach().zero_();
  networks_[kResiduals].last_weight().detach().normal_(0, kRegionResidualSpread);
  networks_[kResiduals].last_bias().detach().zero_();
}

at::Tensor RegionHead::pooled(const Keypoints& keypoints, const at::Tensor& regions,
                              const at::Tensor& scene) {
  const std::int64_t cells = grid_ * grid_ * grid_;
  std::vector<std::int64_t> centre_counts = counts_of(scene, keypoints.counts.size());
  for (std::int64_t& count : centre_counts) count *= cells;
  const at::Tensor centres = sparse::roi_grid_points(to_box_rows(regions), grid_).reshape({-1, 3});
  const at::Tensor rows = pooling_->forward({.points = keypoints.points,
                                             .features = keypoints.features,
                                             .centres = centres,
                                             .point_counts = keypoints.counts,
                                             .centre_counts = centre_counts});
  // Channels first: the order of the columns of published weights.
  return rows.view({regions.size(0), cells, pooling_->out_channels()}).transpose(1, 2).flatten(1);
}

SecondStage RegionHead::forward(const Keypoints& keypoints, const at::Tensor& regions,
                                const at::Tensor& scene) {
  const at::Tensor features = networks_[kShared].forward(pooled(keypoints, regions, scene));
  return {features, networks_[kConfidence].forward(features).squeeze(1),
          networks_[kResiduals].forward(features)};
}

}  // namespace arbox::detectors::pv_rcnn::internal
