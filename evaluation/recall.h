#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "arbox/evaluation/kitti_protocol.h"
#include "arbox/evaluation/uncertainty_protocol.h"

/// \file
/// What a user of a detector sees at one threshold of its score: the share of the plainly visible
/// objects that it finds, and how often it sees what is not there.

namespace arbox::evaluation {

struct RecallOptions {
  std::string label = "Car";
  /// Objects count that are at most this far from the camera over the ground, metres, ...
  double max_range = 40.0;
  /// ... occluded and truncated at most so much (KITTI's levels and shares).
  int max_occlusion = 1;
  double max_truncation = 0.3;
  /// Detections below this score do not count.
  double min_score = 0.5;
  /// An object is found at each of these 3-D IoUs if a detection of its class reaches it.
  std::vector<double> overlaps = {0.5, 0.7};
  /// A detection is false if it overlaps no label of these classes by this 3-D IoU, ...
  std::vector<std::string> resembling = {"Car", "Van", "Truck", "Tram"};
  double false_overlap = 0.3;
  /// ... and at most this share of its 2-D box lies within one DontCare region.
  double dont_care_share = 0.5;
};

struct FoundShare {
  double overlap = 0.0;
  std::size_t found = 0;
  double recall = 0.0;
  /// At 95 %.
  ShareInterval interval = {};
};

struct RecallReport {
  RecallOptions options;
  std::size_t frames = 0, objects = 0, detections = 0, false_detections = 0;
  /// One for each of the options' overlaps.
  std::vector<FoundShare> found;
  double false_per_frame() const;
};

/// Scores frames whose predictions have 2-D boxes and are in the camera's view, as
/// io::to_kitti_results with a calibration makes them. No frames give a report of zeros. Throws
/// InvalidArgument for overlaps outside of (0, 1] and numbers of objects that are not finite.
RecallReport evaluate_recall(std::span<const KittiFrame> frames, const RecallOptions& options = {});

/// {"class": "Car", "max_range": 40.0, "max_occlusion": 1, "max_truncation": 0.3, "min_score": 0.5,
///  "frames": 13, "objects": 20, "detections": 22, "false": 1, "false_per_frame": 0.08,
///  "found": [{"iou": 0.5, "found": 18, "recall": 0.9, "low": 0.7, "high": 0.97}]}
std::string to_json(const RecallReport& report);

/// Lines for a terminal.
std::string to_table(const RecallReport& report);

}  // namespace arbox::evaluation
