#pragma once

#include <ATen/TensorOperators.h>

#include <cmath>
#include <string>
#include <vector>

#include "arbox/base/options.h"
#include "arbox/base/random.h"
#include "arbox/detectors/pv_rcnn/network.h"

namespace arbox::detectors::pv_rcnn {

/// A network of every stage that runs in milliseconds; `more` changes it, one key=value each.
inline Options small_options(bool sparse, const std::vector<std::string>& more = {}) {
  std::vector<std::string> changes = {"voxels.low=[0, -8, -3]",
                                      "voxels.high=[16, 8, 1]",
                                      "voxels.size=[0.25, 0.25, 0.5]",
                                      "voxels.max_voxels=0",
                                      "voxels.max_points_per_voxel=0",
                                      "backbone.channels=[8, 16]",
                                      "backbone.layers=[1, 2]",
                                      "backbone.height_margin=0",
                                      "backbone.out_channels=16",
                                      "birds_eye.channels=[16, 24]",
                                      "birds_eye.layers=[2, 2]",
                                      "birds_eye.up_channels=[16, 16]",
                                      "proposals.count=24",
                                      "keypoints.count=96",
                                      "keypoints.points.widths=[8]",
                                      "keypoints.level1.widths=[8]",
                                      "keypoints.level2.widths=[8, 8]",
                                      "keypoints.level3.radii=[]",
                                      "keypoints.level3.samples=[]",
                                      "keypoints.level4.radii=[]",
                                      "keypoints.level4.samples=[]",
                                      "keypoints.fused=16",
                                      "keypoints.weighting=[16]",
                                      "regions.grid=3",
                                      "regions.pooling.widths=[16]",
                                      "regions.shared=[32]",
                                      "regions.confidence=[16]",
                                      "regions.residuals=[16]",
                                      "post.score=0",
                                      "post.nms_iou=0.3"};
  if (sparse) {
    for (const char* change :
         {"backbone.down_kernel=2", "backbone.vertical_padding=[]", "backbone.out_kernel=4",
          "backbone.out_stride=4", "birds_eye.sparse=true", "keypoints.around=proposals",
          "keypoints.birds_eye=after", "anchors.on_borders=false"}) {
      changes.push_back(change);
    }
  } else {
    changes.push_back("backbone.vertical_padding=[1]");
  }
  changes.insert(changes.end(), more.begin(), more.end());
  return override_options(Options{}, changes);
}

/// The head that most tests use, small.
inline std::vector<std::string> small_autoregressive() {
  return {"head.name=autoregressive", "head.options=['hidden=[32]']", "head.codec.bins=32"};
}

/// Points on the ground and on boxes that stand on it, rows x y z intensity.
inline std::vector<float> made_scan(std::uint64_t seed, int points = 4000) {
  std::vector<float> rows;
  for (int i = 0; i < points; ++i) {
    const RandomStream stream(seed, static_cast<std::uint64_t>(i), 7);
    const bool ground = stream.uniform(0) < 0.5;
    const double corner = 2 + 3 * std::floor(4 * stream.uniform(5));
    const double x = ground ? 16 * stream.uniform(1) : corner + 1.8 * stream.uniform(1);
    const double y = ground ? 16 * stream.uniform(2) - 8 : corner - 8 + 0.9 * stream.uniform(2);
    const double z = ground ? -1.7 : -1.7 + 1.6 * stream.uniform(3);
    for (const double value : {x, y, z, stream.uniform(4)}) {
      rows.push_back(static_cast<float>(value));
    }
  }
  return rows;
}

inline geometry::PointCloudView view_of(const std::vector<float>& rows) {
  return geometry::PointCloudView::packed(rows.data(), rows.size() / 4, {"intensity"});
}

/// Statistics of norms as training leaves them, and scores and residuals that differ from cell to
/// cell.
inline void unsettle(Network& network) {
  for (auto& buffer : network.named_buffers()) {
    if (buffer.key().ends_with("running_mean")) buffer.value().normal_(0, 0.1);
    if (buffer.key().ends_with("running_var")) buffer.value().uniform_(0.5, 1.5);
  }
  for (auto& parameter : network.named_parameters()) {
    const bool last = parameter.key() == "dense_head.conv_box.weight" ||
                      parameter.key() == "roi_head.reg_layers.4.weight";
    if (last) parameter.value().detach().normal_(0, 0.1);
  }
}

inline double largest_difference(const at::Tensor& a, const at::Tensor& b) {
  if (a.numel() == 0) return 0;
  return (a - b).abs().max().item<double>();
}

}  // namespace arbox::detectors::pv_rcnn
