#include "arbox/detectors/pv_rcnn/options.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "arbox/base/error.h"
#include "arbox/base/names.h"
#include "arbox/base/options.h"
#include "arbox/detectors/pv_rcnn/box_coding.h"
#include "arbox/detectors/pv_rcnn/internal/map_cells.h"

namespace arbox::detectors::pv_rcnn {
namespace {

/// Collects what is wrong.
class Violations {
 public:
  void require(bool fine, const std::string& text) {
    if (!fine) texts_.push_back(text);
  }
  void same_length(std::size_t count, std::size_t expected, const char* what) {
    require(count == expected, std::string(what) + ": expected " + std::to_string(expected) +
                                   " entries, got " + std::to_string(count));
  }
  void raise(const std::string& where) const {
    if (!texts_.empty()) throw ConfigError(where + ": " + join(texts_, "; "));
  }

 private:
  std::vector<std::string> texts_;
};

void check_range(const VoxelOptions& voxels, Violations& found) {
  for (int axis = 0; axis < 3; ++axis) {
    const double cells = (voxels.high[axis] - voxels.low[axis]) / voxels.size[axis];
    found.require(cells >= 1 && cells < (1 << 20) && std::abs(cells - std::round(cells)) < 1e-3,
                  "voxels: the range along axis " + std::to_string(axis) + " is " +
                      std::to_string(cells) + " voxels, expected a whole number from 1 to 2^20");
  }
}

void check_abstraction(const AbstractionOptions& options, const std::string& name,
                       Violations& found) {
  found.same_length(options.samples.size(), options.radii.size(), (name + ".samples").c_str());
  found.require(options.radii.empty() || !options.widths.empty(),
                name + ".widths: expected at least one layer");
}

void check_backbone(const Options& options, Violations& found) {
  const BackboneOptions& backbone = options.backbone;
  const std::size_t levels = backbone.channels.size();
  found.require(levels >= 1 && levels <= 4, "backbone.channels: expected 1 to 4 levels");
  if (levels < 1) return;
  found.same_length(backbone.layers.size(), levels, "backbone.layers");
  if (backbone.down_kernel == 3) {
    found.same_length(backbone.vertical_padding.size(), levels - 1, "backbone.vertical_padding");
  }
  const auto sources = options.keypoints.levels();
  for (std::size_t level = 0; level < sources.size(); ++level) {
    const std::string name = "keypoints.level" + std::to_string(level + 1);
    check_abstraction(sources[level], name, found);
    found.require(level < levels || sources[level].radii.empty(),
                  name + ": the backbone has " + std::to_string(levels) + " levels");
  }
}

void check_birds_eye(const BirdsEyeOptions& options, Violations& found) {
  const std::size_t blocks = options.channels.size();
  found.require(blocks >= 1, "birds_eye.channels: expected at least one block");
  found.same_length(options.layers.size(), blocks, "birds_eye.layers");
  found.same_length(options.strides.size(), blocks, "birds_eye.strides");
  found.same_length(options.up_channels.size(), blocks, "birds_eye.up_channels");
}

void check_anchors(const Options& options, Violations& found) {
  const AnchorOptions& anchors = options.anchors;
  const std::size_t classes = options.classes.size();
  found.require(classes >= 1, "classes: expected at least one");
  found.same_length(anchors.lengths.size(), classes, "anchors.lengths");
  found.same_length(anchors.widths.size(), classes, "anchors.widths");
  found.same_length(anchors.heights.size(), classes, "anchors.heights");
  found.same_length(anchors.bottoms.size(), classes, "anchors.bottoms");
  found.same_length(anchors.positive_iou.size(), classes, "anchors.positive_iou");
  found.same_length(anchors.negative_iou.size(), classes, "anchors.negative_iou");
  found.require(!anchors.rotations.empty(), "anchors.rotations: expected at least one");
}

void check_stages(const Options& options, Violations& found) {
  check_abstraction(options.keypoints.points, "keypoints.points", found);
  check_abstraction(options.regions.pooling, "regions.pooling", found);
  found.require(!options.regions.pooling.radii.empty(), "regions.pooling: expected a radius");
  found.require(!options.regions.shared.empty(), "regions.shared: expected at least one layer");
  const KeypointOptions& keypoints = options.keypoints;
  bool gathers = keypoints.birds_eye != "none" || !keypoints.points.radii.empty();
  for (const AbstractionOptions& level : keypoints.levels()) gathers |= !level.radii.empty();
  found.require(gathers, "keypoints: expected at least one source of features");
}

void check_heads(const Options& options, Violations& found) {
  std::vector<std::string> names = {options.head.name};
  const auto known = [&](const std::string& name) {
    return std::find(names.begin(), names.end(), name) != names.end();
  };
  for (const std::string& name : options.more_heads) {
    found.require(!known(name), "more_heads: expected each head once, got '" + name + "' twice");
    names.push_back(name);
  }
  for (const std::string& option : options.more_head_options) {
    const std::string head = option.substr(0, option.find('.'));
    found.require(head != options.head.name && known(head),
                  "more_head_options: expected NAME.KEY=VALUE with a name of more_heads, got '" +
                      option + "'");
  }
  if (!options.post.head.empty() && !known(options.post.head)) {
    found.require(false, "post.head: " + unknown_name_text("head", options.post.head, names));
  }
}

}  // namespace

std::array<int, 3> VoxelOptions::grid() const {
  std::array<int, 3> cells;
  for (int axis = 0; axis < 3; ++axis) {
    cells[axis] = static_cast<int>(std::lround((high[axis] - low[axis]) / size[axis]));
  }
  return cells;
}

void require_valid(const Options& options, const std::string& where) {
  validate_options(options, where);
  Violations found;
  check_range(options.voxels, found);
  check_backbone(options, found);
  check_birds_eye(options.birds_eye, found);
  check_anchors(options, found);
  check_stages(options, found);
  check_heads(options, found);
  found.raise(where);
  const auto cells = internal::map_cells(options);
  found.require(cells.grid[0] >= 1 && cells.grid[1] >= 1 && cells.grid[2] >= 1,
                "backbone: the range has too few voxels for its levels");
  found.require(!options.birds_eye.sparse || cells.grid[2] == 1,
                "birds_eye.sparse: expected a map one cell high, got " +
                    std::to_string(cells.grid[2]) + "; see backbone.out_kernel");
  const auto& strides = options.birds_eye.strides;
  std::int64_t coarsest = 1;
  for (std::size_t block = 1; block < strides.size(); ++block) coarsest *= strides[block];
  const auto map = anchor_cells(options);
  found.require(map[0] % coarsest == 0 && map[1] % coarsest == 0,
                "birds_eye: the map of " + std::to_string(map[0]) + " x " + std::to_string(map[1]) +
                    " cells does not divide by the blocks' strides, " + std::to_string(coarsest));
  found.raise(where);
}

}  // namespace arbox::detectors::pv_rcnn
