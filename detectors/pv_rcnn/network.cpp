#include "arbox/detectors/pv_rcnn/network.h"

#include <ATen/TensorOperators.h>
#include <ATen/ops/arange.h>
#include <ATen/ops/zeros.h>

#include <algorithm>

#include "arbox/base/error.h"
#include "arbox/detectors/pv_rcnn/box_coding.h"
#include "arbox/detectors/pv_rcnn/internal/anchor_head.h"
#include "arbox/detectors/pv_rcnn/internal/birds_eye_backbone.h"
#include "arbox/detectors/pv_rcnn/internal/keypoint_features.h"
#include "arbox/detectors/pv_rcnn/internal/map_cells.h"
#include "arbox/detectors/pv_rcnn/internal/pointwise_branch.h"
#include "arbox/detectors/pv_rcnn/internal/region_head.h"
#include "arbox/detectors/pv_rcnn/internal/row_layer.h"
#include "arbox/detectors/pv_rcnn/internal/sparse_backbone.h"

namespace arbox::detectors::pv_rcnn {
namespace {

std::int64_t map_channels(const Options& options) {
  return options.backbone.out_channels * internal::map_cells(options).grid[2];
}

std::int64_t birds_eye_channels(const Options& options) {
  std::int64_t sum = 0;
  for (const std::int64_t channels : options.birds_eye.up_channels) sum += channels;
  return sum;
}

const Options& validated(const Options& options) {
  require_valid(options, "pv_rcnn");
  return options;
}

/// Cells by scan, then y, then x: the order of anchors.
struct CellOrder {
  at::Tensor rows, places;           // of the tensor; y * width + x
  std::vector<std::int64_t> counts;  // of each scan
};

CellOrder order_of(const sparse::SparseTensor& cells) {
  const auto& [width, height, layers] = *cells.lattice().grid;
  const at::Tensor table = cells.coordinates().to(at::kLong);
  const at::Tensor place = table.select(1, 2) * width + table.select(1, 1);
  const std::int64_t area = std::int64_t{width} * height;
  const at::Tensor rows = (table.select(1, 0) * area + place).argsort();
  CellOrder order{rows, place.index_select(0, rows),
                  std::vector<std::int64_t>(cells.batch_size(), 0)};
  const auto* row = table.data_ptr<std::int64_t>();
  for (std::int64_t i = 0; i < table.size(0); ++i) ++order.counts[row[4 * i]];
  return order;
}

std::shared_ptr<heads::BoxHead> make_region_head(const heads::HeadConfig& head,
                                                 std::int64_t features) {
  if (head.name == "pointwise") {
    if (!head.options.empty()) {
      throw ConfigError("head pointwise: it has no options, got '" + head.options.front() + "'");
    }
    return std::make_shared<internal::PointwiseBranch>(heads::HeadContext{
        .features = features, .condition = kBoxNumbers, .codec = heads::make_codec(head.codec)});
  }
  Registry registry = heads::make_head_registry();
  return heads::make_head(head, features, kBoxNumbers, registry);
}

/// One of the further heads, with the options that are its own.
heads::HeadConfig further_head(const Options& options, const std::string& name) {
  heads::HeadConfig head{.name = name, .options = {}, .codec = options.head.codec};
  for (const std::string& option : options.more_head_options) {
    if (option.starts_with(name + ".")) head.options.push_back(option.substr(name.size() + 1));
  }
  return head;
}

void set_norm_momentum(const torch::nn::Module& backbone, double momentum) {
  for (const auto& module : backbone.modules()) {
    if (auto* norm = module->as<sparse::BatchNorm>()) norm->set_momentum(momentum);
  }
}

}  // namespace

Network::Network(const Options& options)
    : options_(validated(options)), anchors_(make_anchors(options)) {
  backbone_ =
      register_module("backbone_3d", std::make_shared<internal::SparseBackbone>(options_.backbone));
  const bool after = options_.keypoints.birds_eye == "after";
  keypoints_ = register_module(
      "pfe", std::make_shared<internal::KeypointFeatures>(
                 options_, after ? birds_eye_channels(options_) : map_channels(options_)));
  birds_eye_ = register_module("backbone_2d", std::make_shared<internal::BirdsEyeBackbone>(
                                                  options_.birds_eye, map_channels(options_)));
  set_norm_momentum(*backbone_, options_.backbone_norm_momentum);
  set_norm_momentum(*birds_eye_, options_.backbone_norm_momentum);
  anchor_head_ = register_module(
      "dense_head", std::make_shared<internal::AnchorHead>(options_, birds_eye_channels(options_)));
  weighting_ =
      register_module("point_head", std::make_shared<internal::KeypointWeighting>(
                                        options_.keypoints, keypoints_->gathered_channels()));
  regions_ = register_module("roi_head", std::make_shared<internal::RegionHead>(
                                             options_.regions, options_.keypoints.fused));
  const std::int64_t features = options_.regions.shared.back();
  heads_.emplace_back(
      options_.head.name,
      regions_->register_module("box_head", make_region_head(options_.head, features)));
  if (!options_.more_heads.empty()) {
    const auto parent = internal::add_child(*this, "box_heads");
    for (const std::string& name : options_.more_heads) {
      heads_.emplace_back(
          name,
          parent->register_module(name, make_region_head(further_head(options_, name), features)));
    }
  }
  const std::string& answering = options_.post.head;
  head_ = std::find_if(heads_.begin(), heads_.end(), [&](const auto& head) {
            return answering.empty() || head.first == answering;
          })->second;
}

Network::~Network() = default;

FirstStage Network::first_stage(const PointBatch& batch) {
  const at::ScalarType type = anchor_head_->parameters().front().scalar_type();
  auto [levels, cells] =
      backbone_->forward(batch.voxels.with_features(batch.voxels.features().to(type)));
  const std::int64_t anchors = anchor_head_->anchors_per_cell();
  FirstStage first;
  at::Tensor rows;
  if (options_.birds_eye.sparse) {
    const sparse::SparseTensor fused = birds_eye_->forward(cells);
    const CellOrder order = order_of(fused);
    first.cells = options_.keypoints.birds_eye == "after" ? fused : cells;
    rows = fused.features().index_select(0, order.rows);
    first.anchors =
        (order.places.unsqueeze(1) * anchors + at::arange(anchors, at::kLong)).flatten();
    for (const std::int64_t count : order.counts) first.counts.push_back(count * anchors);
  } else {
    const at::Tensor map = internal::to_map(cells);
    const at::Tensor fused = birds_eye_->forward(map);
    first.map = options_.keypoints.birds_eye == "after" ? fused : map;
    rows = fused.permute({0, 2, 3, 1}).reshape({-1, fused.size(1)});
    first.anchors = at::arange(anchors_.size(0), at::kLong).repeat({cells.batch_size()});
    first.counts.assign(cells.batch_size(), anchors_.size(0));
  }
  auto output = anchor_head_->forward(rows);
  first.scores = std::move(output.scores);
  first.residuals = std::move(output.residuals);
  first.directions = std::move(output.directions);
  first.levels = std::move(levels);
  return first;
}

Keypoints Network::keypoints(const PointBatch& batch, const FirstStage& first,
                             const at::Tensor& regions, const at::Tensor& scene) {
  auto chosen = internal::choose_keypoints(batch.points, batch.point_counts, regions, scene,
                                           options_.keypoints);
  const at::Tensor gathered = keypoints_->gather(chosen, batch, first);
  const at::Tensor logits = weighting_->forward(gathered);
  return {std::move(chosen.points), std::move(chosen.counts),
          keypoints_->fuse(gathered) * logits.sigmoid().unsqueeze(1), logits};
}

SecondStage Network::second_stage(const Keypoints& keypoints, const at::Tensor& regions,
                                  const at::Tensor& scene) {
  return regions_->forward(keypoints, regions, scene);
}

heads::HeadInput Network::head_input(const SecondStage& second, const at::Tensor& regions) const {
  const at::Tensor rows = to_box_rows(regions.detach()).to(second.features.scalar_type());
  heads::HeadInput input;
  input.features = second.features;
  input.references = {rows.slice(1, 0, 3), rows.slice(1, 6, 10), rows.slice(1, 3, 6)};
  input.condition = second.residuals;
  return input;
}

heads::HeadInput Network::no_head_input() const {
  const at::Tensor none = at::zeros({0});
  const at::Tensor no_boxes = at::zeros({0, kBoxNumbers});
  return head_input({at::zeros({0, options_.regions.shared.back()}), none, no_boxes}, no_boxes);
}

}  // namespace arbox::detectors::pv_rcnn
