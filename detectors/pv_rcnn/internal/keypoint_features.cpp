#include "arbox/detectors/pv_rcnn/internal/keypoint_features.h"

#include <ATen/TensorOperators.h>
#include <ATen/ops/cat.h>
#include <ATen/ops/empty.h>
#include <ATen/ops/stack.h>
#include <ATen/ops/zeros_like.h>

#include <algorithm>

#include "arbox/detectors/pv_rcnn/internal/map_cells.h"
#include "arbox/detectors/pv_rcnn/internal/scales.h"
#include "arbox/sparse/point_sets.h"
#include "arbox/sparse/voxel_sets.h"

namespace arbox::detectors::pv_rcnn::internal {
namespace {

/// (K) the scan of each keypoint.
at::Tensor scans_of(const ChosenPoints& keypoints) {
  at::Tensor result = at::empty({keypoints.points.size(0)}, at::kFloat);
  float* to = result.data_ptr<float>();
  for (std::size_t scan = 0; scan < keypoints.counts.size(); ++scan) {
    to = std::fill_n(to, keypoints.counts[scan], static_cast<float>(scan));
  }
  return result;
}

std::vector<std::int64_t> voxel_counts(const at::Tensor& coordinates, std::int64_t batch) {
  std::vector<std::int64_t> counts(batch, 0);
  const auto* row = coordinates.data_ptr<std::int32_t>();
  for (std::int64_t i = 0; i < coordinates.size(0); ++i) ++counts[row[4 * i]];
  return counts;
}

}  // namespace

KeypointFeatures::KeypointFeatures(const Options& options, std::int64_t map_channels)
    : options_(options) {
  const KeypointOptions& keypoints = options.keypoints;
  if (keypoints.birds_eye != "none") channels_ += map_channels;
  if (!keypoints.points.radii.empty()) {
    points_ = register_module(
        "SA_rawpoints", std::make_shared<sparse::SetAbstraction>(1, scales(keypoints.points)));
    channels_ += points_->out_channels();
  }
  const auto list = add_child(*this, "SA_layers");
  const auto levels = keypoints.levels();
  for (std::size_t level = 0; level < levels.size(); ++level) {
    if (levels[level].radii.empty()) continue;
    levels_.push_back(
        list->register_module(std::to_string(levels_.size()),
                              std::make_shared<sparse::SetAbstraction>(
                                  options.backbone.channels[level], scales(levels[level]))));
    level_numbers_.push_back(level);
    channels_ += levels_.back()->out_channels();
  }
  fusion_.emplace_back(*add_child(*this, "vsa_point_feature_fusion"), 0, channels_,
                       keypoints.fused);
}

at::Tensor KeypointFeatures::from_map(const ChosenPoints& keypoints,
                                      const FirstStage& first) const {
  const VoxelOptions& voxels = options_.voxels;
  std::int64_t stride = map_cells(options_).stride;
  if (options_.keypoints.birds_eye == "after") stride *= options_.birds_eye.strides.front();
  const auto place = [&](int axis) {
    return (keypoints.points.select(1, axis) - voxels.low[axis]) /
           (voxels.size[axis] * static_cast<double>(stride));
  };
  const at::Tensor scan = scans_of(keypoints);
  if (first.map.defined()) {
    return sparse::sample_birds_eye(first.map, at::stack({scan, place(0), place(1)}, 1));
  }
  return sparse::interpolate(*first.cells,
                             at::stack({scan, place(0), place(1), at::zeros_like(scan)}, 1));
}

at::Tensor KeypointFeatures::from_level(std::size_t source, const ChosenPoints& keypoints,
                                        const sparse::SparseTensor& level) const {
  const VoxelOptions& voxels = options_.voxels;
  const at::Tensor coordinates = level.coordinates();
  const double stride = static_cast<double>(std::int64_t{1} << level_numbers_[source]);
  at::Tensor centres = at::empty({level.size(), 3}, at::kFloat);
  const auto* from = coordinates.data_ptr<std::int32_t>();
  float* to = centres.data_ptr<float>();
  for (std::int64_t i = 0; i < level.size(); ++i) {
    for (int axis = 0; axis < 3; ++axis) {
      *to++ = static_cast<float>((from[4 * i + 1 + axis] + 0.5) * voxels.size[axis] * stride +
                                 voxels.low[axis]);
    }
  }
  const auto counts = voxel_counts(coordinates, level.batch_size());
  return levels_[source]->forward({.points = centres,
                                   .features = level.features(),
                                   .centres = keypoints.points,
                                   .point_counts = counts,
                                   .centre_counts = keypoints.counts});
}

at::Tensor KeypointFeatures::gather(const ChosenPoints& keypoints, const PointBatch& batch,
                                    const FirstStage& first) const {
  std::vector<at::Tensor> parts;
  if (options_.keypoints.birds_eye != "none") parts.push_back(from_map(keypoints, first));
  if (points_) {
    parts.push_back(
        points_->forward({.points = batch.points.slice(1, 0, 3),
                          .features = batch.points.slice(1, 3, 4).to(first.scores.scalar_type()),
                          .centres = keypoints.points,
                          .point_counts = batch.point_counts,
                          .centre_counts = keypoints.counts}));
  }
  for (std::size_t source = 0; source < levels_.size(); ++source) {
    parts.push_back(from_level(source, keypoints, first.levels[level_numbers_[source]]));
  }
  return at::cat(parts, 1);
}

KeypointWeighting::KeypointWeighting(const KeypointOptions& options, std::int64_t in_channels) {
  network_.emplace_back(
      *add_child(*this, "cls_layers"),
      RowNetwork::Shape{.in = in_channels, .hidden = options.weighting, .out = 1});
}

at::Tensor KeypointWeighting::forward(const at::Tensor& gathered) const {
  return network_.front().forward(gathered).squeeze(1);
}

}  // namespace arbox::detectors::pv_rcnn::internal
