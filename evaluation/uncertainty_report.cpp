#include <algorithm>
#include <array>
#include <cstdio>

#include "arbox/evaluation/recall.h"
#include "arbox/evaluation/uncertainty_protocol.h"
#include "arbox/io/json.h"

namespace arbox::evaluation {
namespace {

using io::Json;

template <class... Values>
std::string line(const char* format, Values... values) {
  std::array<char, 256> text{};
  std::snprintf(text.data(), text.size(), format, values...);
  return text.data();
}

Json number_or_null(const std::optional<double>& value) { return value ? Json(*value) : Json(); }

void add_ranking(Json& json, const RankedBoxes& boxes) {
  json["wrong"] = boxes.wrong;
  json["mean_iou"] = boxes.mean_iou;
  json["roc_auc"] = number_or_null(boxes.roc_auc);
  json["spearman"] = number_or_null(boxes.spearman);
  json["chance_roc_auc"] = number_or_null(boxes.chance_roc_auc);
  json["expected"] = boxes.expected
                         ? Json{{"wrong", boxes.expected->wrong},
                                {"roc_auc", number_or_null(boxes.expected->roc_auc)},
                                {"chance_roc_auc", number_or_null(boxes.expected->chance_roc_auc)}}
                         : Json();
}

Json levels_json(const std::vector<BoxLevel>& levels, const char* name) {
  Json result = Json::array();
  for (const BoxLevel& one : levels) {
    result.push_back({{name, one.level},
                      {"promised", one.promised},
                      {"contained", one.contained},
                      {"held", number_or_null(one.held)},
                      {"boxes", one.boxes}});
    add_ranking(result.back(), one);
  }
  return result;
}

Json overlaps_json(const std::vector<PromisedOverlap>& overlaps) {
  Json result = Json::array();
  for (const PromisedOverlap& one : overlaps) {
    result.push_back(
        {{"iou", one.iou}, {"promised", one.promised}, {"kept", one.kept}, {"boxes", one.boxes}});
  }
  return result;
}

Json figures_json(const UncertaintyFigures& figures) {
  Json json = {{"objects", figures.objects},
               {"found", figures.found.boxes},
               {"mean_iog", figures.mean_iog},
               {"f1_of_means", figures.f1_of_means},
               {"mean_f1", figures.mean_f1},
               {"quantile_boxes", levels_json(figures.quantile_boxes, "q")},
               {"sample_boxes", levels_json(figures.sample_boxes, "p")},
               {"confidence_boxes", levels_json(figures.confidence_boxes, "p")},
               {"overlaps", overlaps_json(figures.overlaps)}};
  add_ranking(json, figures.found);
  return json;
}

std::string number_or_dash(const std::optional<double>& value) {
  return value ? line("%8.3f", *value) : line("%8s", "-");
}

std::string figures_row(const UncertaintyFigures& figures) {
  return line("%-12s %7zu %6zu %6zu %7.3f %7.3f %7.3f %7.3f", figures.label.c_str(),
              figures.objects, figures.found.boxes, figures.found.wrong, figures.found.mean_iou,
              figures.mean_iog, figures.f1_of_means, figures.mean_f1) +
         number_or_dash(figures.found.roc_auc) + number_or_dash(figures.found.spearman) + "\n";
}

std::string levels_table(const UncertaintyReport& report, const char* title,
                         std::vector<BoxLevel> UncertaintyFigures::*levels) {
  if ((report.all.*levels).empty()) return {};
  std::string text = line("\n%-12s promised  samples", title);
  for (const UncertaintyFigures& figures : report.classes) {
    text += line(" %12s", figures.label.c_str());
  }
  text += line(" %12s\n", "all");
  for (const BoxLevel& row : report.all.*levels) {
    text += line("%-12g %8.3f ", row.level, row.promised) + number_or_dash(row.held);
    for (const UncertaintyFigures& figures : report.classes) {
      const auto& list = figures.*levels;
      const auto found = std::find_if(list.begin(), list.end(),
                                      [&](const BoxLevel& one) { return one.level == row.level; });
      text += found == list.end() ? line(" %12s", "-") : line(" %12.3f", found->contained);
    }
    text += line(" %12.3f\n", row.contained);
  }
  return text;
}

std::string overlaps_table(const UncertaintyReport& report) {
  if (report.all.overlaps.empty()) return {};
  std::string text = line("\n%-12s %8s %8s %6s\n", "IoU at least", "promised", "kept", "boxes");
  for (const PromisedOverlap& row : report.all.overlaps) {
    text += line("%-12g %8.3f %8.3f %6zu\n", row.iou, row.promised, row.kept, row.boxes);
  }
  return text;
}

std::string ranking_row(const std::string& boxes, const RankedBoxes& row) {
  std::string text =
      line("%-12s %6zu %6zu %7.3f", boxes.c_str(), row.boxes, row.wrong, row.mean_iou) +
      number_or_dash(row.roc_auc) + number_or_dash(row.spearman);
  if (row.expected) {
    text += line(" %9.1f", row.expected->wrong) + number_or_dash(row.expected->roc_auc) +
            number_or_dash(row.chance_roc_auc) + number_or_dash(row.expected->chance_roc_auc);
  }
  return text + "\n";
}

/// What the uncertainty tells of the quantile boxes, as in the paper's table of its measures, and
/// what the samples expect of it.
std::string rankings_table(const UncertaintyReport& report) {
  const auto& rows = report.all.quantile_boxes;
  const bool ranked =
      std::any_of(rows.begin(), rows.end(), [](const BoxLevel& row) { return row.spearman; });
  if (!ranked) return {};
  std::string text =
      line("\n%-12s %6s %6s %7s%8s%8s", "quantile q", "boxes", "wrong", "IoU", "ROC AUC", "r_s");
  if (rows.front().expected) {
    text += line(" %9s%8s%8s%8s", "wrong*", "AUC*", "chance", "chance*");
  }
  text += "\n" + ranking_row("own", report.all.found);
  for (const BoxLevel& row : rows) text += ranking_row(line("%g", row.level), row);
  if (rows.front().expected) {
    text += "chance: ROC AUC of the samples' chance of a wrong box; *: as the samples expect\n";
  }
  return text;
}

}  // namespace

std::string to_json(const UncertaintyReport& report) {
  Json json = {{"protocol", "uncertainty"},
               {"scans", report.scans},
               {"min_iog", report.options.min_iog},
               {"wrong_iou", report.options.wrong_iou},
               {"max_distance", report.options.max_distance},
               {"min_score", report.options.min_score},
               {"classes", Json::object()},
               {"all", figures_json(report.all)}};
  for (const UncertaintyFigures& figures : report.classes) {
    json["classes"][figures.label] = figures_json(figures);
  }
  return io::dump_json(json, 1) + "\n";
}

std::string to_table(const UncertaintyReport& report) {
  std::string text = line(
      "%zu scans; found: centre within %g m, score from %g; wrong: IoU below %g\n\n", report.scans,
      report.options.max_distance, report.options.min_score, report.options.wrong_iou);
  text += line("%-12s %7s %6s %6s %7s %7s %7s %7s%8s%8s\n", "class", "objects", "found", "wrong",
               "IoU", "IoG", "F1", "mean F1", "ROC AUC", "r_s");
  for (const UncertaintyFigures& figures : report.classes) text += figures_row(figures);
  text += figures_row(report.all);
  text += levels_table(report, "quantile q", &UncertaintyFigures::quantile_boxes);
  text += levels_table(report, "samples p", &UncertaintyFigures::sample_boxes);
  text += levels_table(report, "confidence p", &UncertaintyFigures::confidence_boxes);
  return text + overlaps_table(report) + rankings_table(report);
}

std::string to_json(const RecallReport& report) {
  const RecallOptions& options = report.options;
  Json json = {{"class", options.label},
               {"max_range", options.max_range},
               {"max_occlusion", options.max_occlusion},
               {"max_truncation", options.max_truncation},
               {"min_score", options.min_score},
               {"frames", report.frames},
               {"objects", report.objects},
               {"detections", report.detections},
               {"false", report.false_detections},
               {"false_per_frame", report.false_per_frame()},
               {"found", Json::array()}};
  for (const FoundShare& share : report.found) {
    json["found"].push_back({{"iou", share.overlap},
                             {"found", share.found},
                             {"recall", share.recall},
                             {"low", share.interval.low},
                             {"high", share.interval.high}});
  }
  return io::dump_json(json, 1) + "\n";
}

std::string to_table(const RecallReport& report) {
  const RecallOptions& options = report.options;
  std::string text =
      line("%s within %g m, occlusion up to %d, truncation up to %g, score from %g: %zu objects\n",
           options.label.c_str(), options.max_range, options.max_occlusion, options.max_truncation,
           options.min_score, report.objects);
  for (const FoundShare& share : report.found) {
    text += line("  recall at IoU %.2f  %.3f (95 %%: %.3f .. %.3f)\n", share.overlap, share.recall,
                 share.interval.low, share.interval.high);
  }
  return text + line("  false            %.3f a frame (%zu in %zu)\n", report.false_per_frame(),
                     report.false_detections, report.frames);
}

}  // namespace arbox::evaluation
