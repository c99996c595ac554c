#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "arbox/evaluation/kitti_protocol.h"

namespace arbox::evaluation {

enum KittiMetric { kImage, kBirdsEye, kBox3d, kKittiMetrics };

/// A frame with everything that does not depend on class and difficulty worked out once.
struct PreparedKittiFrame {
  const KittiFrame* frame = nullptr;
  /// predictions x labels, per metric.
  std::array<Eigen::MatrixXd, kKittiMetrics> overlaps;
  /// Largest share of each prediction's 2-D box inside of one DontCare region.
  std::vector<double> dont_care_share;
};

PreparedKittiFrame prepare_kitti_frame(const KittiFrame& frame, const KittiOptions& options);

/// One cell of the evaluation.
struct KittiTask {
  const KittiClass* settings = nullptr;
  KittiMetric metric = kImage;
  int difficulty = 0;
  double min_overlap() const;
};

/// The matching of one frame for one task.
class KittiMatching {
 public:
  /// The frame must outlive the matching.
  KittiMatching(const PreparedKittiFrame& prepared, const KittiTask& task);

  /// Labels that count.
  std::int64_t valid_labels() const { return valid_labels_; }
  /// True if a prediction takes part, so that count() can be other than zero.
  bool has_predictions() const;
  /// Appends the scores of the true positives when every prediction takes part and a label takes
  /// its best-scored candidate.
  void collect_scores(std::vector<double>& scores) const;

  struct Counts {
    std::int64_t true_positives = 0;
    std::int64_t false_positives = 0;
    double similarity = 0.0;
  };
  /// Counts when the predictions with at least `threshold` take part and a label takes its
  /// candidate of largest overlap.
  Counts count(double threshold) const;

 private:
  struct Candidate {
    int prediction;
    double overlap;
  };
  struct Label {
    double alpha;
    bool ignored;
    std::vector<Candidate> candidates;
  };
  struct Prediction {
    double score;
    double alpha;
    bool ignored;
    bool in_dont_care;
  };

  std::int64_t valid_labels_ = 0;
  std::vector<Label> labels_;
  std::vector<Prediction> predictions_;
};

}  // namespace arbox::evaluation
