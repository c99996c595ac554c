#pragma once

#include <string>
#include <string_view>

#include "arbox/evaluation/indoor_protocol.h"
#include "arbox/evaluation/kitti_protocol.h"

/// \file
/// Results as text: JSON for programs (docs/formats.md, "Evaluation reports"), tables for people.

namespace arbox::evaluation {

/// "iou" or "iog".
std::string_view overlap_name(geometry::Overlap overlap);

/// AP in percent, curves in [0, 1]; metrics that were not computed are absent:
///
///     {"protocol": "kitti", "overlap": "iou", "bev_overlap": "iou", "frames": 3769,
///      "objects": {"Car": {"easy": 1, "moderate": 2, "hard": 3, "predictions": 4}},
///      "min_overlap": {"Car": {"2d": 0.7, "bev": 0.7, "3d": 0.7}},
///      "ap": {"Car": {"3d": {"R40": {"easy": 90.85, "moderate": 82.29, "hard": 77.72},
///                            "R11": {...}}, "bev": {...}, "2d": {...}, "aos": {...}}},
///      "curves": {"Car": {"3d": {"easy": [41 values], ...}, ...}}}
std::string to_json(const KittiReport& report);

/// AP and recall in percent by threshold ("0.25") and as "mean" over 0.05, 0.10, ..., 0.95, curves
/// in [0, 1]; classes without truth are absent from "ap", "recall" and "curves":
///
///     {"protocol": "indoor", "overlap": "iou", "scenes": 8,
///      "objects": {"bed": {"truth": 8, "predictions": 70}},
///      "ap": {"bed": {"0.25": 100.0, "0.50": 100.0, "mean": 60.0}},
///      "recall": {"bed": {...}},
///      "map": {"0.25": 70.3, ..., "mean": 42.1}, "mean_recall": {...},
///      "curves": {"bed": {"0.25": {"recall": [...], "precision": [...]}}}}
std::string to_json(const IndoorReport& report);

/// Lines for a terminal, each ended. `shown` are the thresholds that get columns.
std::string to_table(const KittiReport& report);
std::string to_table(const IndoorReport& report, const std::vector<double>& shown = {0.25, 0.50});

}  // namespace arbox::evaluation
