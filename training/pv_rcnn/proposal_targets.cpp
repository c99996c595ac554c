#include "arbox/training/pv_rcnn/proposal_targets.h"

#include <ATen/TensorOperators.h>
#include <ATen/ops/cat.h>
#include <ATen/ops/cos.h>
#include <ATen/ops/full.h>
#include <ATen/ops/where.h>

#include <algorithm>
#include <numbers>
#include <numeric>
#include <string>

#include "arbox/base/error.h"
#include "arbox/base/options.h"
#include "arbox/base/random.h"
#include "arbox/geometry/overlap.h"
#include "arbox/heads/box_tensor.h"
#include "arbox/sparse/point_sets.h"
#include "arbox/training/internal/purposes.h"
#include "arbox/training/internal/tensors.h"

namespace arbox::training::pv_rcnn {
namespace {

using at::Tensor;
using geometry::Box;

constexpr double kLeastSize = 1e-3, kLargestSize = 1e4;

/// The proposals of one scan and how well they fit its objects.
struct Fit {
  std::vector<double> iou;
  std::vector<std::int64_t> object;
  std::vector<double> similar_iou;
};

Fit fit(std::span<const Box> boxes, std::span<const std::int64_t> labels,
        std::span<const SceneObject> objects) {
  Fit result{std::vector<double>(boxes.size(), 0.0), std::vector<std::int64_t>(boxes.size(), -1),
             std::vector<double>(boxes.size(), 0.0)};
  std::vector<Box> targets;
  for (const SceneObject& object : objects) targets.push_back(object.box);
  const auto overlaps = geometry::overlap_matrix(boxes, targets);
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    for (std::size_t j = 0; j < objects.size(); ++j) {
      const double iou = overlaps(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j));
      if (objects[j].label == labels[i]) {
        if (result.object[i] >= 0 && iou <= result.iou[i]) continue;
        result.iou[i] = iou;
        result.object[i] = static_cast<std::int64_t>(j);
      } else if (objects[j].label < 0 && objects[j].resembles == labels[i]) {
        result.similar_iou[i] = std::max(result.similar_iou[i], iou);
      }
    }
  }
  return result;
}

std::span<const std::int64_t> whole_numbers(const Tensor& tensor, Tensor& keep) {
  keep = tensor.to(at::kCPU, at::kLong).contiguous();
  return {keep.data_ptr<std::int64_t>(), static_cast<std::size_t>(keep.numel())};
}

/// Draws rows of a scan's proposals; every draw has its own index of the stream.
class Draw {
 public:
  Draw(const ProposalTargetOptions& options, const RandomStream& random)
      : options_(options), random_(random) {}

  std::vector<std::size_t> rows(const std::vector<double>& iou) {
    std::vector<std::size_t> foreground, hard, easy;
    for (std::size_t i = 0; i < iou.size(); ++i) {
      (iou[i] >= options_.foreground_iou ? foreground : (iou[i] >= options_.hard_iou ? hard : easy))
          .push_back(i);
    }
    std::vector<std::size_t> drawn;
    if (hard.empty() && easy.empty()) {
      add_any(foreground, options_.count, drawn);
      return drawn;
    }
    const int most = static_cast<int>(options_.count * options_.foreground_share);
    add_distinct(std::move(foreground), most, drawn);
    const int background = options_.count - static_cast<int>(drawn.size());
    const int hard_count = easy.empty()
                               ? background
                               : std::min(static_cast<int>(background * options_.hard_share),
                                          static_cast<int>(hard.size()));
    add_any(hard, hard_count, drawn);
    add_any(easy, background - hard_count, drawn);
    return drawn;
  }

 private:
  void add_any(const std::vector<std::size_t>& rows, int count, std::vector<std::size_t>& to) {
    for (int i = 0; i < count && !rows.empty(); ++i) {
      to.push_back(rows[random_.below(next_++, static_cast<std::uint32_t>(rows.size()))]);
    }
  }

  void add_distinct(std::vector<std::size_t> rows, int count, std::vector<std::size_t>& to) {
    const std::size_t taken = std::min(rows.size(), static_cast<std::size_t>(count));
    for (std::size_t i = 0; i < taken; ++i) {
      const auto left = static_cast<std::uint32_t>(rows.size() - i);
      std::swap(rows[i], rows[i + random_.below(next_++, left)]);
      to.push_back(rows[i]);
    }
  }

  const ProposalTargetOptions& options_;
  const RandomStream& random_;
  std::uint32_t next_ = 0;
};

void require_valid(const ProposalTargetOptions& options) {
  validate_options(options, "proposal targets");
  if (options.confidence_low >= options.confidence_high) {
    throw ConfigError("proposal targets: expected confidence_low below confidence_high, got " +
                      std::to_string(options.confidence_low) + " and " +
                      std::to_string(options.confidence_high));
  }
}

double confidence_of(double iou, double similar_iou, const ProposalTargetOptions& options,
                     bool ignore_similar) {
  if (ignore_similar && iou < options.foreground_iou && similar_iou > options.confidence_low) {
    return -1.0;
  }
  return std::clamp(
      (iou - options.confidence_low) / (options.confidence_high - options.confidence_low), 0.0,
      1.0);
}

/// First row of each scan among rows of never falling scan numbers, and the end.
std::vector<std::size_t> scan_starts(std::span<const std::int64_t> scenes, std::size_t scans) {
  std::vector<std::size_t> starts(scans + 1, 0);
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    if (scenes[i] < 0 || static_cast<std::size_t>(scenes[i]) >= scans ||
        (i > 0 && scenes[i] < scenes[i - 1])) {
      throw InvalidArgument("proposal targets: proposal " + std::to_string(i) +
                            ": expected scans in order below " + std::to_string(scans) + ", got " +
                            std::to_string(scenes[i]));
    }
    ++starts[static_cast<std::size_t>(scenes[i]) + 1];
  }
  std::partial_sum(starts.begin(), starts.end(), starts.begin());
  return starts;
}

/// How well proposals fit the objects of their scans, scan by scan.
class ScanFits {
 public:
  ScanFits(const detectors::pv_rcnn::Proposals& proposals, const SceneObjects& objects)
      : objects_(objects), rows_(proposals.boxes.detach()) {
    boxes_ = internal::to_boxes(
        at::cat({rows_.slice(1, 0, 3), rows_.slice(1, 3, 6).clamp(kLeastSize, kLargestSize),
                 rows_.slice(1, 6, 7)},
                1));
    labels_ = whole_numbers(proposals.labels, keep_labels_);
    Tensor scenes;
    starts_ = scan_starts(whole_numbers(proposals.scene, scenes), objects.size());
  }

  const Tensor& rows() const { return rows_; }
  std::size_t start(std::size_t scan) const { return starts_[scan]; }
  Fit of(std::size_t scan) const {
    const std::size_t start = starts_[scan], count = starts_[scan + 1] - start;
    return fit(std::span(boxes_).subspan(start, count), labels_.subspan(start, count),
               objects_[scan]);
  }

 private:
  const SceneObjects& objects_;
  Tensor rows_, keep_labels_;
  std::vector<Box> boxes_;
  std::span<const std::int64_t> labels_;
  std::vector<std::size_t> starts_;
};

}  // namespace

ProposalTargets draw_proposals(const detectors::pv_rcnn::Proposals& proposals,
                               const SceneObjects& objects, const ProposalTargetOptions& options,
                               bool ignore_similar, std::uint64_t seed, std::int64_t first_scene) {
  require_valid(options);
  const ScanFits scans(proposals, objects);
  std::vector<std::int64_t> drawn, foreground;
  std::vector<double> iou, confidence;
  std::vector<SceneObject> targets;
  for (std::size_t scan = 0; scan < objects.size(); ++scan) {
    const Fit fits = scans.of(scan);
    const RandomStream random(seed, static_cast<std::uint64_t>(first_scene) + scan,
                              internal::kSampledProposals);
    for (const std::size_t row : Draw(options, random).rows(fits.iou)) {
      if (fits.object[row] >= 0 && fits.iou[row] >= options.foreground_iou) {
        foreground.push_back(static_cast<std::int64_t>(drawn.size()));
        targets.push_back(objects[scan][fits.object[row]]);
      }
      drawn.push_back(static_cast<std::int64_t>(scans.start(scan) + row));
      iou.push_back(fits.iou[row]);
      confidence.push_back(
          confidence_of(fits.iou[row], fits.similar_iou[row], options, ignore_similar));
    }
  }
  const Tensor index = internal::to_tensor(drawn);
  const at::ScalarType type = scans.rows().scalar_type();
  return {.boxes = scans.rows().index_select(0, index),
          .labels = proposals.labels.index_select(0, index),
          .scene = proposals.scene.index_select(0, index),
          .iou = internal::to_tensor(iou, type),
          .confidence = internal::to_tensor(confidence, type),
          .foreground = internal::to_tensor(foreground),
          .objects = internal::to_rows(targets, type)};
}

MatchedProposals match_proposals(const detectors::pv_rcnn::Proposals& proposals,
                                 const SceneObjects& objects, double least_iou) {
  const ScanFits scans(proposals, objects);
  std::vector<std::int64_t> rows;
  std::vector<SceneObject> targets;
  for (std::size_t scan = 0; scan < objects.size(); ++scan) {
    const Fit fits = scans.of(scan);
    for (std::size_t row = 0; row < fits.iou.size(); ++row) {
      if (fits.object[row] < 0 || fits.iou[row] < least_iou) continue;
      rows.push_back(static_cast<std::int64_t>(scans.start(scan) + row));
      targets.push_back(objects[scan][fits.object[row]]);
    }
  }
  return {internal::to_tensor(rows), internal::to_rows(targets, scans.rows().scalar_type())};
}

Tensor aligned_boxes(const Tensor& boxes, const Tensor& regions) {
  const Tensor difference = boxes.slice(-1, 6, 7) - regions.slice(-1, 6, 7);
  const Tensor yaw = at::where(at::cos(difference) < 0, boxes.slice(-1, 6, 7) + std::numbers::pi,
                               boxes.slice(-1, 6, 7));
  return at::cat({boxes.slice(-1, 0, 6), yaw}, -1);
}

Tensor keypoint_targets(const Tensor& points, std::span<const std::int64_t> counts,
                        const SceneObjects& objects, double ring, bool ignore_similar) {
  Tensor result = at::full({points.size(0)}, 0.0, at::kFloat);
  std::int64_t start = 0;
  for (std::size_t scan = 0; scan < counts.size(); ++scan) {
    std::vector<Box> found, similar;
    for (const SceneObject& object : objects.at(scan)) {
      if (object.label >= 0) {
        found.push_back(object.box);
      } else if (ignore_similar && object.resembles >= 0) {
        similar.push_back(object.box);
      }
    }
    const Tensor here = points.slice(0, start, start + counts[scan]);
    Tensor target = result.slice(0, start, start + counts[scan]);
    const auto inside = [&](std::span<const Box> boxes, double margin) {
      return sparse::points_in_boxes(here, heads::to_tensor(boxes, at::kDouble), margin) >= 0;
    };
    target.masked_fill_(inside(similar, 0.0), -1.0);
    target.masked_fill_(inside(found, 0.5 * ring), -1.0);
    target.masked_fill_(inside(found, 0.0), 1.0);
    start += counts[scan];
  }
  return result;
}

}  // namespace arbox::training::pv_rcnn
