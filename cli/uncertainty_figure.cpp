#include "arbox/cli/uncertainty_figure.h"

#include <algorithm>
#include <cmath>

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

/// A share of `boxes` against what was promised, with its interval at 95 %.
void add_share(drawing::Series& series, double promised, double share, std::size_t boxes) {
  const auto hits = static_cast<std::size_t>(std::llround(share * static_cast<double>(boxes)));
  const auto interval = evaluation::share_interval(hits, boxes);
  series.x.push_back(promised);
  series.y.push_back(share);
  series.low.push_back(interval.low);
  series.high.push_back(interval.high);
}

drawing::Series promise_line(const std::string& name, std::vector<BoxLevel> levels) {
  std::sort(levels.begin(), levels.end(),
            [](const auto& first, const auto& second) { return first.promised < second.promised; });
  drawing::Series series;
  series.name = name;
  series.markers = true;
  for (const BoxLevel& level : levels) {
    add_share(series, level.promised, level.contained, level.boxes);
  }
  return series;
}

/// Levels that promise the share of the samples that their boxes hold; those that know it.
std::vector<BoxLevel> promising_held(std::vector<BoxLevel> levels) {
  std::erase_if(levels, [](const BoxLevel& level) { return !level.held; });
  for (BoxLevel& level : levels) level.promised = *level.held;
  return levels;
}

drawing::Panel held_panel() {
  drawing::Panel panel = promise_panel("quantile boxes, by what they hold");
  panel.x.label = "held of the samples";
  return panel;
}

drawing::Panel overlap_panel() {
  drawing::Panel panel = promise_panel("overlap by an IoU of 0.25, 0.5, 0.7");
  panel.x.label = "promised by the samples";
  panel.y.label = "kept";
  return panel;
}

/// Both axes from the tenth below the least share to 1.
void zoom(drawing::Panel& panel) {
  double least = 1.0;
  for (const drawing::Series& series : panel.series) {
    for (const auto* shares : {&series.x, &series.y}) {
      for (const double share : *shares) least = std::min(least, share);
    }
  }
  panel.x.low = panel.y.low = std::floor(std::min(least, 0.9) * 10.0) / 10.0;
}

drawing::Series overlap_line(const std::string& name,
                             const std::vector<evaluation::PromisedOverlap>& overlaps) {
  drawing::Series series;
  series.name = name;
  series.markers = true;
  for (const auto& overlap : overlaps) {
    add_share(series, overlap.promised, overlap.kept, overlap.boxes);
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
  return drawing::draw_figure(
      panels, {.title = std::to_string(report.all.found.boxes) + " found objects in " +
                        std::to_string(report.scans) + " scans"});
}

drawing::Image draw_promises(std::span<const NamedUncertainty> detectors,
                             const std::string& title) {
  std::vector<drawing::Panel> panels = {promise_panel("quantile boxes of q = 1 - p"), held_panel(),
                                        promise_panel("boxes that hold p of the samples"),
                                        overlap_panel()};
  for (const NamedUncertainty& detector : detectors) {
    if (detector.name == kGaussianDeviation) continue;
    const auto& all = detector.report.all;
    panels[0].series.push_back(promise_line(detector.name, all.quantile_boxes));
    panels[1].series.push_back(promise_line(detector.name, promising_held(all.quantile_boxes)));
    panels[2].series.push_back(promise_line(detector.name, all.sample_boxes));
    panels[3].series.push_back(overlap_line(detector.name, all.overlaps));
  }
  for (drawing::Panel& panel : panels) {
    std::erase_if(panel.series, [](const drawing::Series& one) { return one.x.empty(); });
  }
  // Most boxes overlap their objects.
  if (!panels[3].series.empty()) zoom(panels[3]);
  return drawing::draw_figure(panels, {.title = title, .columns = 2});
}

}  // namespace arbox::cli
