#pragma once

#include <ATen/core/ivalue.h>
// ivalue.h must come before the module header (clang).
#include <torch/nn/module.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "arbox/detectors/pv_rcnn/options.h"
#include "arbox/geometry/point_cloud_view.h"
#include "arbox/heads/box_head.h"
#include "arbox/sparse/sparse_tensor.h"

/// \file
/// PV-RCNN's network, stage by stage. Boxes are (N, 7), see box_coding.h. LiDAR frame, metres.

namespace arbox::detectors::pv_rcnn {

namespace internal {
class SparseBackbone;
class BirdsEyeBackbone;
class AnchorHead;
class KeypointFeatures;
class KeypointWeighting;
class RegionHead;
}  // namespace internal

/// Scans of a batch, cropped to the range; non-finite points are left out.
struct PointBatch {
  at::Tensor points;                       ///< (P, 4) float32: x y z intensity, scan by scan.
  std::vector<std::int64_t> point_counts;  ///< Points of each scan, summing to P.
  sparse::SparseTensor voxels;      ///< Mean of the points of each voxel (V, 4) on a grid lattice.
  std::int64_t dropped_points = 0;  ///< Points with a coordinate that is not finite.
};

/// Points inside the range along x and y, and voxels inside all of it, with the limits of the
/// options.
///
/// Clouds without an `intensity` channel get 0. Intensities of a cloud whose largest is above 1 are
/// taken as 0..255 (above 255: as 0..65535) and divided; those that are not finite count as 0. With
/// Options::sensor_height points are shifted in z. More points than VoxelOptions::max_points are
/// thinned evenly by their number. In training the points of cloud i are shuffled by
/// (seed, first_scan + i).
/// A cloud without points in range gives a scan without points and voxels.
PointBatch make_batch(std::span<const geometry::PointCloudView> clouds, const Options& options,
                      bool training, std::uint64_t seed, std::uint64_t first_scan = 0);

/// Candidates of the anchor head, scan by scan: every anchor of a dense network, those of the cells
/// near something of a sparse one. All (N, ...) with gradient.
struct FirstStage {
  at::Tensor anchors;  ///< (N) int64: rows of Network::anchors(), rising in each scan.
  std::vector<std::int64_t> counts;  ///< Candidates of each scan, summing to N.
  at::Tensor scores;                 ///< (N, classes) logits.
  at::Tensor residuals;              ///< (N, 7) to the anchor.
  at::Tensor directions;             ///< (N, 2) logits.
  /// What keypoints gather from: the map (B, C, H, W) of a dense network, the cells of a sparse
  /// one, the levels of the 3-D backbone from the finest on.
  at::Tensor map;
  std::optional<sparse::SparseTensor> cells;
  std::vector<sparse::SparseTensor> levels;
};

/// Regions of interest, detached: best score first in each scan, scan by scan.
struct Proposals {
  at::Tensor boxes;                ///< (R, 7).
  at::Tensor scores;               ///< (R) logit of the best class.
  at::Tensor labels;               ///< (R) int64: class.
  at::Tensor scene;                ///< (R) int64: scan of the batch.
  std::int64_t dropped_boxes = 0;  ///< Left out because a number was not finite.
};

struct Keypoints {
  at::Tensor points;                 ///< (K, 3), scan by scan.
  std::vector<std::int64_t> counts;  ///< Keypoints of each scan; 0 for a scan without points.
  at::Tensor features;               ///< (K, fused), weighted by sigmoid(logits).
  at::Tensor logits;                 ///< (K): whether a keypoint lies on an object.
};

struct SecondStage {
  at::Tensor features;    ///< (R, last shared width): what the head gets.
  at::Tensor confidence;  ///< (R) logits.
  at::Tensor residuals;   ///< (R, 7) pointwise branch, in the frame of the region.
};

/// Heads by name.
using NamedHeads = std::vector<std::pair<std::string, std::shared_ptr<heads::BoxHead>>>;

/// PV-RCNN (Shi et al., CVPR 2020) with heads of heads/; `pointwise` is PV-RCNN's own branch
/// (internal/pointwise_branch.h). Parameters carry the names of OpenPCDet's checkpoints; those of
/// the head begin with `roi_head.box_head`, those of further heads with `box_heads.NAME`. Batch
/// norms are sparse::BatchNorm.
///
/// Parameters may be turned into float64: features and what follows from them are then float64,
/// places stay float32. Without gradients and in eval mode norms are folded into the layers before
/// them; the network may then be used from several threads. Outputs have gradients to all
/// parameters; boxes, points and places have none.
class Network : public torch::nn::Module {
 public:
  /// Throws ConfigError for options that do not fit together; as heads::make_head for the heads.
  explicit Network(const Options& options);
  ~Network() override;

  const Options& options() const { return options_; }
  /// (A, 7), see make_anchors.
  const at::Tensor& anchors() const { return anchors_; }

  FirstStage first_stage(const PointBatch& batch);

  /// The best anchors of each scan, decoded, after suppression from above. Ties go to the lower
  /// anchor.
  Proposals propose(const FirstStage& first, const ProposalOptions& options) const;

  /// regions (R, 7) of the scans `scene` (R), in order: where keypoints go if the options spread
  /// them around proposals.
  Keypoints keypoints(const PointBatch& batch, const FirstStage& first, const at::Tensor& regions,
                      const at::Tensor& scene);

  /// scene (R) must not fall.
  SecondStage second_stage(const Keypoints& keypoints, const at::Tensor& regions,
                           const at::Tensor& scene);

  /// Options::head first, then Options::more_heads.
  const NamedHeads& heads() const { return heads_; }
  /// The one that answers: PostOptions::head.
  heads::BoxHead& head() { return *head_; }
  /// Features, the regions as references, the pointwise residuals as condition.
  heads::HeadInput head_input(const SecondStage& second, const at::Tensor& regions) const;
  /// The same of no regions: heads answer it with a distribution of size 0, which tells what they
  /// can be asked.
  heads::HeadInput no_head_input() const;

 private:
  Options options_;
  at::Tensor anchors_;
  std::shared_ptr<internal::SparseBackbone> backbone_;
  std::shared_ptr<internal::KeypointFeatures> keypoints_;
  std::shared_ptr<internal::BirdsEyeBackbone> birds_eye_;
  std::shared_ptr<internal::AnchorHead> anchor_head_;
  std::shared_ptr<internal::KeypointWeighting> weighting_;
  std::shared_ptr<internal::RegionHead> regions_;
  NamedHeads heads_;
  std::shared_ptr<heads::BoxHead> head_;
};

}  // namespace arbox::detectors::pv_rcnn
