#include "arbox/evaluation/report.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <utility>

#include "arbox/base/error.h"
#include "arbox/io/json.h"

namespace arbox::evaluation {
namespace {

using io::Json;

struct Metric {
  const char* name;
  const char* title;
  std::optional<KittiCurves> KittiClassResult::*curves;
};
constexpr std::array<Metric, 4> kMetrics = {
    {{"3d", "3-D", &KittiClassResult::box3d},
     {"bev", "bird's eye", &KittiClassResult::birds_eye},
     {"2d", "2-D", &KittiClassResult::image},
     {"aos", "orientation", &KittiClassResult::orientation}}};

template <class... Values>
std::string print(const char* format, Values... values) {
  std::array<char, 256> text{};
  std::snprintf(text.data(), text.size(), format, values...);
  return text.data();
}

std::string upper(std::string_view name) { return name == "iou" ? "IoU" : "IoG"; }

Json average_precisions(const KittiCurves& curves) {
  Json result;
  for (std::size_t d = 0; d < curves.size(); ++d) {
    const std::string difficulty(kKittiDifficulties[d]);
    result["R40"][difficulty] = curves[d].r40();
    result["R11"][difficulty] = curves[d].r11();
  }
  return result;
}

Json values_of(const KittiCurves& curves) {
  Json result;
  for (std::size_t d = 0; d < curves.size(); ++d) {
    result[std::string(kKittiDifficulties[d])] = curves[d].values;
  }
  return result;
}

std::string threshold_name(double threshold) {
  const std::string two_digits = print("%.2f", threshold);
  return std::stod(two_digits) == threshold ? two_digits : print("%.17g", threshold);
}

Json by_threshold(const IndoorReport& report, const std::vector<IndoorScore>& scores,
                  const IndoorScore& mean, double IndoorScore::*value) {
  Json result;
  for (std::size_t t = 0; t < report.thresholds.size(); ++t) {
    result[threshold_name(report.thresholds[t])] = scores[t].*value;
  }
  result["mean"] = mean.*value;
  return result;
}

std::size_t name_width(const std::vector<std::string>& names) {
  std::size_t width = 10;
  for (const std::string& name : names) width = std::max(width, name.size());
  return width;
}

std::string indoor_row(const IndoorReport& report, const std::vector<double>& shown,
                       const std::vector<IndoorScore>& scores, const IndoorScore& mean) {
  std::string row;
  for (const double threshold : shown) {
    const IndoorScore& score = scores[threshold_index(report, threshold)];
    row += print("  %8.2f %8.2f", score.ap, score.recall);
  }
  return row + print("  %8.2f %8.2f\n", mean.ap, mean.recall);
}

}  // namespace

std::string_view overlap_name(geometry::Overlap overlap) {
  switch (overlap) {
    case geometry::Overlap::kIou:
      return "iou";
    case geometry::Overlap::kIog:
      return "iog";
    case geometry::Overlap::kIntersection:
      break;
  }
  throw InvalidArgument("overlap_name: expected IoU or IoG, got the intersection");
}

std::string to_json(const KittiReport& report) {
  Json json = {{"protocol", "kitti"},
               {"overlap", overlap_name(report.overlap)},
               {"bev_overlap", overlap_name(report.birds_eye_overlap)},
               {"frames", report.frames},
               {"objects", Json::object()},
               {"min_overlap", Json::object()},
               {"ap", Json::object()},
               {"curves", Json::object()}};
  for (const KittiClassResult& result : report.classes) {
    const KittiClass& settings = result.settings;
    Json& objects = json["objects"][settings.name];
    for (std::size_t d = 0; d < 3; ++d) {
      objects[std::string(kKittiDifficulties[d])] = result.labels[d];
    }
    objects["predictions"] = result.predictions;
    json["min_overlap"][settings.name] = {{"2d", settings.min_overlap.image},
                                          {"bev", settings.min_overlap.birds_eye},
                                          {"3d", settings.min_overlap.box3d}};
    for (const Metric& metric : kMetrics) {
      const auto& curves = result.*metric.curves;
      if (!curves) continue;
      json["ap"][settings.name][metric.name] = average_precisions(*curves);
      json["curves"][settings.name][metric.name] = values_of(*curves);
    }
  }
  return io::dump_json(json, 1) + "\n";
}

std::string to_json(const IndoorReport& report) {
  Json json = {{"protocol", "indoor"},    {"overlap", overlap_name(report.overlap)},
               {"scenes", report.scenes}, {"objects", Json::object()},
               {"ap", Json::object()},    {"recall", Json::object()}};
  Json curves = Json::object();
  bool any_truth = false;
  for (const IndoorClassResult& result : report.classes) {
    json["objects"][result.name] = {{"truth", result.truth}, {"predictions", result.predictions}};
    if (result.scores.empty()) continue;
    any_truth = true;
    json["ap"][result.name] = by_threshold(report, result.scores, result.mean, &IndoorScore::ap);
    json["recall"][result.name] =
        by_threshold(report, result.scores, result.mean, &IndoorScore::recall);
    for (std::size_t t = 0; t < report.thresholds.size(); ++t) {
      curves[result.name][threshold_name(report.thresholds[t])] = {
          {"recall", result.curves[t].recall}, {"precision", result.curves[t].precision}};
    }
  }
  if (any_truth) {
    json["map"] = by_threshold(report, report.class_means, report.mean, &IndoorScore::ap);
    json["mean_recall"] =
        by_threshold(report, report.class_means, report.mean, &IndoorScore::recall);
  }
  json["curves"] = std::move(curves);
  return io::dump_json(json, 1) + "\n";
}

std::string to_table(const KittiReport& report) {
  std::string text = print(
      "KITTI, %lld frames, 3-D overlap %s, bird's-eye overlap %s; average precision in percent\n",
      static_cast<long long>(report.frames), upper(overlap_name(report.overlap)).c_str(),
      upper(overlap_name(report.birds_eye_overlap)).c_str());
  for (const KittiClassResult& result : report.classes) {
    text +=
        print("\n%s: %lld / %lld / %lld labels, %lld predictions\n", result.settings.name.c_str(),
              static_cast<long long>(result.labels[0]), static_cast<long long>(result.labels[1]),
              static_cast<long long>(result.labels[2]), static_cast<long long>(result.predictions));
    if (std::none_of(kMetrics.begin(), kMetrics.end(),
                     [&](const Metric& metric) { return (result.*metric.curves).has_value(); })) {
      text += "  nothing to score\n";
      continue;
    }
    text += print("  %-18s %8s %9s %8s %10s %9s %8s\n", "", "easy", "moderate", "hard", "easy",
                  "moderate", "hard");
    for (const Metric& metric : kMetrics) {
      const auto& curves = result.*metric.curves;
      if (!curves) continue;
      const KittiThresholds& overlaps = result.settings.min_overlap;
      const double threshold = metric.curves == &KittiClassResult::box3d       ? overlaps.box3d
                               : metric.curves == &KittiClassResult::birds_eye ? overlaps.birds_eye
                                                                               : overlaps.image;
      text += print("  %-11s > %.2f R40 %6.2f %9.2f %8.2f  R11 %6.2f %9.2f %8.2f\n", metric.title,
                    threshold, (*curves)[0].r40(), (*curves)[1].r40(), (*curves)[2].r40(),
                    (*curves)[0].r11(), (*curves)[1].r11(), (*curves)[2].r11());
    }
  }
  return text;
}

std::string to_table(const IndoorReport& report, const std::vector<double>& shown) {
  std::string text =
      print("Indoor, %lld scenes, overlap %s; average precision and recall in percent\n\n",
            static_cast<long long>(report.scenes), upper(overlap_name(report.overlap)).c_str());
  std::vector<std::string> names;
  for (const IndoorClassResult& result : report.classes) names.push_back(result.name);
  const int width = static_cast<int>(name_width(names));
  text += print("%-*s %7s %11s", width, "class", "truth", "predictions");
  for (const double threshold : shown) {
    text += print("   AP %4.2f   recall", threshold);
  }
  text += "   AP mean   recall\n";
  for (const IndoorClassResult& result : report.classes) {
    text += print("%-*s %7lld %11lld", width, result.name.c_str(),
                  static_cast<long long>(result.truth), static_cast<long long>(result.predictions));
    text += result.scores.empty() ? "  no truth, so no AP\n"
                                  : indoor_row(report, shown, result.scores, result.mean);
  }
  if (!names.empty()) {
    text += print("%-*s %7s %11s", width, "mean", "", "");
    text += indoor_row(report, shown, report.class_means, report.mean);
  }
  return text;
}

}  // namespace arbox::evaluation
