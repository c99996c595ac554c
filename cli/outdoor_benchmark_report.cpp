#include <algorithm>
#include <array>
#include <cstdio>

#include "arbox/cli/outdoor_benchmark.h"
#include "arbox/drawing/curves.h"
#include "arbox/evaluation/report.h"
#include "arbox/io/json.h"

namespace arbox::cli {
namespace {

using evaluation::KittiReport;
using io::Json;

constexpr char kPointwise[] = "pointwise";

template <class... Values>
std::string text(const char* format, Values... values) {
  std::array<char, 256> line{};
  std::snprintf(line.data(), line.size(), format, values...);
  return line.data();
}

Json number_or_null(const std::optional<double>& value) { return value ? Json(*value) : Json(); }

/// Markdown's header row and the one below it.
std::string header(const std::vector<std::string>& names) {
  std::string first = "|", second = "|";
  for (const std::string& name : names) {
    first += " " + name + " |";
    second += "---|";
  }
  return first + "\n" + second + "\n";
}

std::string precision_table(const OutdoorBenchmark& benchmark, KittiReport BenchmarkRow::*report) {
  std::string result = header({"detector", "box", "Car easy", "mod.", "hard", "Pedestrian easy",
                               "mod.", "hard", "Cyclist easy", "mod.", "hard"});
  for (const BenchmarkRow& row : benchmark.rows) {
    result += "| " + row.detector + " | " + row.box + " |";
    for (const auto& of_class : (row.*report).classes) {
      for (std::size_t d = 0; d < evaluation::kKittiDifficulties.size(); ++d) {
        result += of_class.box3d ? text(" %.2f |", (*of_class.box3d)[d].r40()) : " - |";
      }
    }
    result += "\n";
  }
  return result;
}

std::string recall_table(const OutdoorBenchmark& benchmark) {
  std::string result = header({"detector", "box", "recall at IoU 0.5", "at 0.7",
                               "false cars a scan", "ms a scan (median)", "95 %"});
  for (const BenchmarkRow& row : benchmark.rows) {
    result += "| " + row.detector + " | " + row.box + " |";
    for (const auto& share : row.recall.found) {
      result += text(" %.3f (%.3f..%.3f) |", share.recall, share.interval.low, share.interval.high);
    }
    result += text(" %.2f |", row.recall.false_per_frame());
    for (const auto& time : {row.median_milliseconds, row.slow_milliseconds}) {
      result += time ? text(" %.0f |", *time) : " |";
    }
    result += "\n";
  }
  return result;
}

/// A cell of a table, behind its bar.
std::string figure_cell(const std::optional<double>& value) {
  return value ? text(" %.3f |", *value) : " - |";
}

std::string uncertainty_table(const OutdoorBenchmark& benchmark) {
  std::string result = header({"detector", "found", "mean IoU", "F1 of means", "ROC AUC",
                               "Spearman", "contained, by q (1 - q; held of the samples)",
                               "by p of the samples (p; held)", "by p, calibrated (p; held)"});
  for (const NamedUncertainty& one : benchmark.uncertainty) {
    const auto& all = one.report.all;
    result += text("| %s | %zu of %zu | %.3f | %.3f |", one.name.c_str(), all.found.boxes,
                   all.objects, all.found.mean_iou, all.f1_of_means);
    result += figure_cell(all.found.roc_auc) + figure_cell(all.found.spearman);
    for (const auto* levels : {&all.quantile_boxes, &all.sample_boxes, &all.confidence_boxes}) {
      for (const auto& level : *levels) {
        result += text(" %g: %.3f (%.2f", level.level, level.contained, level.promised) +
                  (level.held ? text("; %.3f)", *level.held) : ")");
      }
      result += " |";
    }
    result += "\n";
  }
  return result;
}

std::string expected_cells(const evaluation::RankedBoxes& ranked) {
  if (!ranked.expected) return " - | - | - | - |";
  return text(" %.1f |", ranked.expected->wrong) + figure_cell(ranked.expected->roc_auc) +
         figure_cell(ranked.chance_roc_auc) + figure_cell(ranked.expected->chance_roc_auc);
}

/// What the uncertainty tells of each detector's own boxes and of its quantile boxes, and what the
/// samples expect of that.
std::string ranking_table(const OutdoorBenchmark& benchmark) {
  std::string result =
      header({"uncertainty of", "boxes", "objects", "wrong", "mean IoU", "ROC AUC", "Spearman",
              "wrong, expected", "ROC AUC, expected", "of the samples' chance", "expected"});
  const auto add = [&](const std::string& name, const std::string& boxes,
                       const evaluation::RankedBoxes& ranked) {
    result += "| " + name + " | " + boxes +
              text(" | %zu | %zu | %.3f |", ranked.boxes, ranked.wrong, ranked.mean_iou) +
              figure_cell(ranked.roc_auc) + figure_cell(ranked.spearman) + expected_cells(ranked) +
              "\n";
  };
  for (const NamedUncertainty& one : benchmark.uncertainty) {
    const auto& all = one.report.all;
    add(one.name, "its own", all.found);
    for (const evaluation::BoxLevel& level : all.quantile_boxes) {
      add(one.name, text("q %.2f", level.level), level);
    }
  }
  return result;
}

/// How often boxes overlap their objects, and how often the samples say that they do.
std::string overlap_table(const OutdoorBenchmark& benchmark) {
  std::string result = header({"samples of", "IoU at least", "promised", "kept"});
  for (const NamedUncertainty& one : benchmark.uncertainty) {
    if (one.name == kGaussianDeviation) continue;
    for (const auto& row : one.report.all.overlaps) {
      result +=
          text("| %s | %g | %.3f | %.3f |\n", one.name.c_str(), row.iou, row.promised, row.kept);
    }
  }
  return result;
}

/// Bars of the boxes of a detector; beside those of a head the pointwise ones.
drawing::Panel precision_panel(const OutdoorBenchmark& benchmark, const std::string& detector) {
  drawing::Panel panel;
  panel.title = detector;
  panel.legend_above = true;
  panel.y = {.label = "AP of cars, hard, 3-D (percent)", .low = 0.0, .high = 100.0};
  panel.bars = {{.name = "IoU", .heights = {}}, {.name = "IoG", .heights = {}}};
  const auto height = [](const KittiReport& report) {
    constexpr std::size_t kHard = 2;
    const auto& car = report.classes.front();
    return car.box3d ? (*car.box3d)[kHard].r40() : 0.0;
  };
  for (const BenchmarkRow& row : benchmark.rows) {
    const bool compared = row.detector == kPointwise && detector != "cluster_fit";
    if (row.detector != detector && !compared) continue;
    panel.categories.push_back(row.box);
    panel.bars[0].heights.push_back(height(row.iou));
    panel.bars[1].heights.push_back(height(row.iog));
  }
  return panel;
}

}  // namespace

std::string to_json(const OutdoorBenchmark& benchmark) {
  Json json = {{"benchmark", "outdoor"},
               {"title", benchmark.title},
               {"model", benchmark.options.model},
               {"scans", benchmark.scans},
               {"threads", benchmark.threads},
               {"peak_memory_megabytes", benchmark.peak_memory},
               {"rows", Json::array()},
               {"uncertainty", Json::object()}};
  for (const BenchmarkRow& row : benchmark.rows) {
    json["rows"].push_back({{"detector", row.detector},
                            {"box", row.box},
                            {"iou", Json::parse(evaluation::to_json(row.iou))},
                            {"iog", Json::parse(evaluation::to_json(row.iog))},
                            {"recall", Json::parse(evaluation::to_json(row.recall))},
                            {"median_milliseconds", number_or_null(row.median_milliseconds)},
                            {"slow_milliseconds", number_or_null(row.slow_milliseconds)}});
  }
  for (const NamedUncertainty& one : benchmark.uncertainty) {
    json["uncertainty"][one.name] = Json::parse(evaluation::to_json(one.report));
  }
  return io::dump_json(json, 1) + "\n";
}

std::string to_markdown(const OutdoorBenchmark& benchmark) {
  const auto& options = benchmark.options;
  std::string result = "# " + benchmark.title + "\n\n";
  if (!options.model.empty()) result += "Model: " + options.model + "\n\n";
  result += "3-D average precision (R40, percent), IoU:\n\n" +
            precision_table(benchmark, &BenchmarkRow::iou) +
            "\n3-D average precision (R40, percent), IoG:\n\n" +
            precision_table(benchmark, &BenchmarkRow::iog);
  if (!benchmark.rows.empty()) {
    const auto& recall = benchmark.rows[0].recall;
    result +=
        text(
            "\nCars within %g m, occlusion up to %d, truncation up to %g, score from %g "
            "(%zu cars; 95 %% interval), and speed on %d threads:\n\n",
            recall.options.max_range, recall.options.max_occlusion, recall.options.max_truncation,
            recall.options.min_score, recall.objects, benchmark.threads) +
        recall_table(benchmark);
  }
  result += text("\nFound objects (score from %g), %s:\n\n", options.found_score,
                 options.all_round ? "all directions" : "in the camera's view") +
            uncertainty_table(benchmark) +
            "\nWhat the uncertainty tells of boxes, as in the paper's table of its measures:\n\n" +
            ranking_table(benchmark) +
            "\nHow often boxes overlap their objects, and how often their samples say so:\n\n" +
            overlap_table(benchmark) +
            text("\nLargest memory of the whole run: %.0f MB.\n", benchmark.peak_memory);
  return result;
}

drawing::Image draw_average_precision(const OutdoorBenchmark& benchmark) {
  std::vector<std::string> detectors;
  for (const BenchmarkRow& row : benchmark.rows) {
    const bool known =
        std::find(detectors.begin(), detectors.end(), row.detector) != detectors.end();
    if (!known && row.detector != kPointwise) detectors.push_back(row.detector);
  }
  if (detectors.empty()) detectors.push_back(kPointwise);
  std::vector<drawing::Panel> panels;
  panels.reserve(detectors.size());
  for (const std::string& detector : detectors) {
    panels.push_back(precision_panel(benchmark, detector));
  }
  return drawing::draw_figure(panels, {.title = benchmark.title});
}

}  // namespace arbox::cli
