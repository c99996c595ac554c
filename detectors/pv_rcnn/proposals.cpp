#include <ATen/TensorOperators.h>
#include <ATen/ops/cat.h>
#include <ATen/ops/empty.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "arbox/detectors/pv_rcnn/box_coding.h"
#include "arbox/detectors/pv_rcnn/internal/box_rows.h"
#include "arbox/detectors/pv_rcnn/network.h"
#include "arbox/geometry/nms.h"

namespace arbox::detectors::pv_rcnn {
namespace {

/// Candidates of one scan: their rows, best score first.
struct Ranking {
  std::vector<std::int64_t> rows;
  std::int64_t dropped = 0;
};

/// The `most` rows of [begin, end) with the highest scores; ties go to the lower row.
Ranking rank(const float* scores, std::int64_t begin, std::int64_t end, int most) {
  Ranking ranking;
  ranking.rows.reserve(end - begin);
  for (std::int64_t i = begin; i < end; ++i) {
    if (std::isfinite(scores[i])) ranking.rows.push_back(i);
  }
  ranking.dropped = end - begin - std::ssize(ranking.rows);
  const auto better = [scores](std::int64_t a, std::int64_t b) {
    return scores[a] != scores[b] ? scores[a] > scores[b] : a < b;
  };
  const auto kept = std::min<std::int64_t>(most, std::ssize(ranking.rows));
  std::nth_element(ranking.rows.begin(), ranking.rows.begin() + kept, ranking.rows.end(), better);
  ranking.rows.resize(kept);
  std::sort(ranking.rows.begin(), ranking.rows.end(), better);
  return ranking;
}

at::Tensor index_tensor(const std::vector<std::int64_t>& index) {
  at::Tensor result = at::empty({std::ssize(index)}, at::kLong);
  std::copy(index.begin(), index.end(), result.data_ptr<std::int64_t>());
  return result;
}

}  // namespace

Proposals Network::propose(const FirstStage& first, const ProposalOptions& options) const {
  const auto [best, labels] = first.scores.detach().max(1);
  const at::Tensor scores = best.to(at::kFloat).contiguous();
  std::vector<at::Tensor> all_boxes;
  std::vector<std::int64_t> rows, scenes;
  Proposals result;
  std::int64_t begin = 0;
  for (std::size_t scan = 0; scan < first.counts.size(); ++scan) {
    const std::int64_t end = begin + first.counts[scan];
    const Ranking ranking = rank(scores.data_ptr<float>(), begin, end, options.candidates);
    begin = end;
    const at::Tensor index = index_tensor(ranking.rows);
    at::Tensor boxes =
        decode_residuals(first.residuals.detach().index_select(0, index).to(at::kFloat),
                         anchors_.index_select(0, first.anchors.index_select(0, index)));
    boxes.select(1, 6).copy_(resolve_directions(boxes.select(1, 6),
                                                first.directions.detach().index_select(0, index),
                                                options_.anchors.direction_offset));
    const internal::UsableBoxes usable = internal::usable_boxes(boxes);
    result.dropped_boxes += ranking.dropped + usable.dropped;
    std::vector<double> values;
    for (const std::int64_t row : usable.rows) {
      values.push_back(scores.data_ptr<float>()[ranking.rows[row]]);
    }
    const auto kept = geometry::nms(usable.boxes, values,
                                    {.threshold = options.iou, .post_limit = options.count});
    std::vector<std::int64_t> chosen;
    for (const std::int64_t i : kept.kept) {
      chosen.push_back(usable.rows[i]);
      rows.push_back(ranking.rows[usable.rows[i]]);
      scenes.push_back(static_cast<std::int64_t>(scan));
    }
    all_boxes.push_back(boxes.index_select(0, index_tensor(chosen)));
  }
  const at::Tensor index = index_tensor(rows);
  result.boxes = all_boxes.empty() ? at::empty({0, kBoxNumbers}, at::kFloat) : at::cat(all_boxes);
  result.scores = scores.index_select(0, index);
  result.labels = labels.index_select(0, index);
  result.scene = index_tensor(scenes);
  return result;
}

}  // namespace arbox::detectors::pv_rcnn
