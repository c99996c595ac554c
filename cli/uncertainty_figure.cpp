#include "arbox/cli/uncertainty_figure.h"

#include <algorithm>

#include "arbox/drawing/curves.h"

namespace arbox::cli {
namespace {

using evaluation::BoxLevel;
using evaluation::UncertaintyReport;

drawing::Panel promise_panel(const std::string& title) {
  drawing::Panel panel;
  panel.title = title;
  panel.x = {.label = "promised", .low = 0.0, .high = 1.0};
  panel.y = {.label = "contained", .low = 0.0, .high = 1.0};
  panel.diagonal = true;
  return panel;
}

drawing::Series promise_line(const std::string& name, std::vector<BoxLevel> levels) {
  std::sort(levels.begin(), levels.end(),
            [](const auto& first, const auto& second) { return first.promised < second.promised; });
  drawing::Series series;
  series.name = name;
  series.markers = true;
  for (const BoxLevel& level : levels) {
    const auto hits =
        static_cast<std::size_t>(level.contained * static_cast<double>(level.boxes) + 0.5);
    const auto interval = evaluation::share_interval(hits, level.boxes);
    series.x.push_back(level.promised);
    series.y.push_back(level.contained);
    series.low.push_back(interval.low);
    series.high.push_back(interval.high);
  }
  return series;
}

drawing::Panel uncertainty_panel(const UncertaintyReport& report) {
  drawing::Panel panel;
  panel.title = "found objects";
  panel.x = {.label = "uncertainty", .low = 0.0, .high = {}};
  panel.y = {.label = "IoU", .low = 0.0, .high = 1.0};
  for (const auto& figures : report.classes) {
    drawing::Series series;
    series.name = figures.label;
    series.line = drawing::LineStyle::kNone;
    series.markers = true;
    for (const auto& found : report.found) {
      if (found.label != figures.label || !found.uncertainty) continue;
      series.x.push_back(*found.uncertainty);
      series.y.push_back(found.iou);
    }
    if (!series.x.empty()) panel.series.push_back(std::move(series));
  }
  return panel;
}

}  // namespace

drawing::Image draw_uncertainty(const UncertaintyReport& report) {
  std::vector<drawing::Panel> panels;
  const auto add = [&](const std::string& title, auto levels) {
    drawing::Panel panel = promise_panel(title);
    for (const auto& figures : report.classes) {
      if ((figures.*levels).empty()) continue;
      panel.series.push_back(promise_line(figures.label, figures.*levels));
    }
    if (!panel.series.empty()) panels.push_back(std::move(panel));
  };
  add("quantile boxes", &evaluation::UncertaintyFigures::quantile_boxes);
  add("boxes that hold p of the samples", &evaluation::UncertaintyFigures::sample_boxes);
  add("confidence boxes", &evaluation::UncertaintyFigures::confidence_boxes);
  panels.push_back(uncertainty_panel(report));
  return drawing::draw_figure(panels,
                              {.title = std::to_string(report.all.found) + " found objects in " +
                                        std::to_string(report.scans) + " scans"});
}

drawing::Image draw_containment(std::span<const NamedUncertainty> detectors,
                                const std::string& title) {
  std::vector<drawing::Panel> panels;
  const auto add = [&](const char* kind, auto levels) {
    drawing::Panel panel = promise_panel(kind);
    for (const NamedUncertainty& detector : detectors) {
      const auto& of_all = detector.report.all.*levels;
      if (!of_all.empty()) panel.series.push_back(promise_line(detector.name, of_all));
    }
    if (panels.empty() || !panel.series.empty()) panels.push_back(std::move(panel));
  };
  add("quantile boxes of q = 1 - p", &evaluation::UncertaintyFigures::quantile_boxes);
  add("boxes that hold p of the samples", &evaluation::UncertaintyFigures::sample_boxes);
  return drawing::draw_figure(panels, {.title = title});
}

}  // namespace arbox::cli
