#include "arbox/training/pv_rcnn/kept_regions.h"

#include <ATen/TensorOperators.h>
#include <ATen/core/grad_mode.h>
#include <ATen/ops/cat.h>
#include <ATen/ops/from_blob.h>

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "arbox/base/error.h"
#include "arbox/detectors/pv_rcnn/box_coding.h"
#include "arbox/io/npy.h"
#include "arbox/training/durable_file.h"
#include "arbox/training/pv_rcnn/proposal_targets.h"

namespace arbox::training::pv_rcnn {
namespace {

using at::Tensor;
using detectors::pv_rcnn::kBoxNumbers;

/// Columns beside the features.
constexpr std::int64_t kNumbers = 3 * kBoxNumbers;

Tensor columns(const KeptRegions& regions) {
  return at::cat({regions.features, regions.residuals, regions.boxes, regions.objects}, 1)
      .to(at::kFloat)
      .contiguous();
}

KeptRegions from_columns(const Tensor& rows) {
  const std::int64_t features = rows.size(1) - kNumbers;
  const auto part = [&](std::int64_t first, std::int64_t count) {
    return rows.slice(1, features + first, features + first + count);
  };
  return {rows.slice(1, 0, features), part(0, kBoxNumbers), part(kBoxNumbers, kBoxNumbers),
          part(2 * kBoxNumbers, kBoxNumbers)};
}

}  // namespace

KeptRegions detected_regions(detectors::pv_rcnn::Network& network, const Scene& scene,
                             const std::vector<SceneObject>& objects, double least_iou) {
  const at::NoGradGuard no_gradient;
  const auto batch =
      detectors::pv_rcnn::make_batch({{scene.cloud.view()}}, network.options(), false, 0);
  const auto first = network.first_stage(batch);
  const auto proposals = network.propose(first, network.options().proposals);
  const auto keypoints = network.keypoints(batch, first, proposals.boxes, proposals.scene);
  const auto second = network.second_stage(keypoints, proposals.boxes, proposals.scene);
  const MatchedProposals matched = match_proposals(proposals, {objects}, least_iou);
  return {second.features.index_select(0, matched.rows),
          second.residuals.index_select(0, matched.rows),
          proposals.boxes.index_select(0, matched.rows), matched.objects};
}

KeptRegions joined(const std::vector<std::shared_ptr<const KeptRegions>>& parts) {
  std::vector<Tensor> rows;
  for (const auto& part : parts) rows.push_back(columns(*part));
  return from_columns(at::cat(rows));
}

void write_kept_regions(const std::filesystem::path& file, const KeptRegions& regions) {
  const Tensor rows = columns(regions);
  const auto extent = [&](int axis) { return static_cast<std::size_t>(rows.size(axis)); };
  write_durably(file, io::encode_npy(std::span<const float>(rows.data_ptr<float>(),
                                                            static_cast<std::size_t>(rows.numel())),
                                     {extent(0), extent(1)}));
}

KeptRegions read_kept_regions(const std::filesystem::path& file) {
  const io::NpyArray array = io::read_npy(file);
  const auto& shape = array.shape();
  if (shape.size() != 2 || shape[1] <= static_cast<std::size_t>(kNumbers)) {
    throw FormatError(file.string() + ": expected kept regions, an array of rows of more than " +
                      std::to_string(kNumbers) + " numbers; remove the file to have it made anew");
  }
  std::vector<float> values = array.values<float>();
  return from_columns(
      at::from_blob(values.data(),
                    {static_cast<std::int64_t>(shape[0]), static_cast<std::int64_t>(shape[1])},
                    at::kFloat)
          .clone());
}

KeptRegionsSource::KeptRegionsSource(const SceneSource& scenes, std::filesystem::path folder)
    : scenes_(scenes), folder_(std::move(folder)) {
  std::error_code error;
  std::filesystem::create_directories(folder_, error);
  if (error) throw IoError(folder_.string() + ": cannot be made: " + error.message());
}

Scene KeptRegionsSource::scene(std::int64_t index) const {
  const std::filesystem::path file = folder_ / (std::to_string(index) + ".npy");
  Scene scene;
  if (std::filesystem::exists(file)) {
    scene.regions = std::make_shared<KeptRegions>(read_kept_regions(file));
    scene.source = file.string();
  } else {
    scene = scenes_.scene(index);
    scene.regions_file = file;
  }
  return scene;
}

}  // namespace arbox::training::pv_rcnn
