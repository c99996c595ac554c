#include "arbox/cli/evaluation_figure.h"

#include <array>
#include <cstdio>
#include <string>
#include <vector>

#include "arbox/drawing/curves.h"
#include "arbox/evaluation/report.h"

namespace arbox::cli {
namespace {

using evaluation::IndoorReport;
using evaluation::KittiClassResult;
using evaluation::KittiCurves;
using evaluation::KittiReport;

std::string with_figure(const std::string& name, double percent) {
  std::array<char, 64> text{};
  std::snprintf(text.data(), text.size(), " %.2f", percent);
  return name + text.data();
}

drawing::Panel empty_panel(const std::string& title, const std::string& y) {
  return {.title = title,
          .x = {.label = "recall", .low = 0.0, .high = 1.0},
          .y = {.label = y, .low = 0.0, .high = 1.0}};
}

drawing::Panel kitti_panel(const std::string& title, const std::string& y,
                           const KittiCurves& curves) {
  drawing::Panel panel = empty_panel(title, y);
  for (std::size_t d = 0; d < curves.size(); ++d) {
    drawing::Series series;
    series.name = with_figure(std::string(evaluation::kKittiDifficulties[d]), curves[d].r40());
    for (std::size_t i = 0; i < curves[d].values.size(); ++i) {
      series.x.push_back(static_cast<double>(i) / 40.0);
      series.y.push_back(curves[d].values[i]);
    }
    panel.series.push_back(std::move(series));
  }
  return panel;
}

drawing::Panel indoor_panel(const IndoorReport& report, double threshold) {
  drawing::Panel panel = empty_panel(with_figure("overlap above", threshold), "precision");
  const std::size_t t = evaluation::threshold_index(report, threshold);
  for (const auto& result : report.classes) {
    if (result.scores.empty()) continue;
    drawing::Series series;
    series.name = with_figure(result.name, result.scores[t].ap);
    const evaluation::PrecisionRecall& curve = result.curves[t];
    // Steps: between two recalls the best precision is that of the higher one.
    double reached = 0.0;
    for (std::size_t i = 0; i < curve.recall.size(); ++i) {
      series.x.insert(series.x.end(), {reached, curve.recall[i]});
      series.y.insert(series.y.end(), {curve.precision[i], curve.precision[i]});
      reached = curve.recall[i];
    }
    series.x.push_back(reached);
    series.y.push_back(0.0);
    panel.series.push_back(std::move(series));
  }
  return panel;
}

}  // namespace

drawing::Image draw_precision_recall(const KittiReport& report) {
  std::vector<drawing::Panel> panels;
  const std::string three_d = report.overlap == geometry::Overlap::kIog ? "3-D (IoG)" : "3-D";
  const std::string birds_eye =
      report.birds_eye_overlap == geometry::Overlap::kIog ? "bird's eye (IoG)" : "bird's eye";
  for (const KittiClassResult& result : report.classes) {
    const std::string& name = result.settings.name;
    const auto add = [&](const std::string& metric, const std::string& y,
                         const std::optional<KittiCurves>& curves) {
      if (curves) panels.push_back(kitti_panel(name + ", " + metric, y, *curves));
    };
    add(three_d, "precision", result.box3d);
    add(birds_eye, "precision", result.birds_eye);
    add("2-D", "precision", result.image);
    add("orientation", "orientation similarity", result.orientation);
  }
  if (panels.empty()) panels.push_back(empty_panel("nothing to score", "precision"));
  return drawing::draw_figure(
      panels, {.title = "KITTI, " + std::to_string(report.frames) + " frames (legend: AP R40)",
               .columns = panels.size() == 1 ? 1 : (panels.size() % 4 == 0 ? 4 : 3),
               .panel_width = 460,
               .panel_height = 380});
}

drawing::Image draw_precision_recall(const IndoorReport& report) {
  const std::vector<drawing::Panel> panels = {indoor_panel(report, 0.25),
                                              indoor_panel(report, 0.50)};
  const std::string measure = report.overlap == geometry::Overlap::kIog ? "IoG" : "IoU";
  return drawing::draw_figure(
      panels, {.title = measure + ", " + std::to_string(report.scenes) + " scenes (legend: AP)"});
}

}  // namespace arbox::cli
