#include "plots.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "arbox/drawing/curves.h"
#include "divergence.h"

namespace arbox::benchmarks {
namespace {

using drawing::Panel;
constexpr drawing::Color kReal{0, 114, 178}, kSimulated{213, 94, 0};

Panel scan_panel(const std::string& title, const std::string& axis, Select select, double step,
                 const std::vector<ScanFigures>& real, const std::vector<ScanFigures>& simulated) {
  Panel panel{.title = title, .x = {.label = axis}, .y = {.label = "share"}};
  for (const auto& [name, scans] : {std::pair{"real", &real}, {"simulated", &simulated}}) {
    const Histogram heights = shares(all_of(*scans), select);
    drawing::Series series;
    series.name = name;
    for (std::size_t i = 0; i < heights.size(); ++i) {
      series.x.push_back((static_cast<double>(i) + 0.5) * step);
      series.y.push_back(heights[i]);
    }
    panel.series.push_back(series);
  }
  return panel;
}

/// Median with a band from the 10 % to the 90 % quantile; bins with fewer than five values break
/// the line.
drawing::Series band(const std::string& name, drawing::Color color, double first, double step,
                     const std::vector<std::vector<double>>& bins) {
  drawing::Series series{.name = name, .x = {}, .y = {}, .color = color};
  for (std::size_t i = 0; i < bins.size(); ++i) {
    const bool enough = bins[i].size() >= 5;
    series.x.push_back(first + (static_cast<double>(i) + 0.5) * step);
    series.y.push_back(enough ? quantile(bins[i], .5) : std::nan(""));
    series.low.push_back(enough ? quantile(bins[i], .1) : std::nan(""));
    series.high.push_back(enough ? quantile(bins[i], .9) : std::nan(""));
  }
  return series;
}

Panel points_panel(const std::string& type, const std::vector<ScanFigures>& real,
                   const std::vector<ScanFigures>& simulated) {
  Panel panel{.title = type + ", in full view",
              .x = {.label = "distance, m", .low = 0, .high = 70},
              .y = {.label = "points", .low = 3, .high = 5000, .logarithmic = true}};
  std::vector<std::vector<double>> bins(14);
  for (const ScanFigures& scan : simulated) {
    for (const ObjectFigures& object : scan.objects) {
      const auto bin = static_cast<std::size_t>(object.distance / 5);
      if (object.type == type && object.clear() && bin < bins.size()) {
        bins[bin].push_back(object.points);
      }
    }
  }
  panel.series.push_back(band("simulated, 10 to 90 %", kSimulated, 0, 5, bins));
  drawing::Series dots{.name = "real",
                       .x = {},
                       .y = {},
                       .line = drawing::LineStyle::kNone,
                       .markers = true,
                       .color = kReal};
  for (const ScanFigures& scan : real) {
    for (const ObjectFigures& object : scan.objects) {
      if (object.type != type || !object.clear()) continue;
      dots.x.push_back(object.distance);
      dots.y.push_back(object.points);
    }
  }
  panel.series.push_back(dots);
  return panel;
}

Panel ground_panel(const std::vector<ScanFigures>& real,
                   const std::vector<ScanFigures>& simulated) {
  Panel panel{.title = "Ground: lowest points of sectors of 10 degrees",
              .x = {.label = "distance, m"},
              .y = {.label = "height, m", .low = -3.5, .high = 1.5}};
  for (const auto& [name, color, scans] :
       {std::tuple{"real", kReal, &real}, {"simulated", kSimulated, &simulated}}) {
    std::vector<std::vector<double>> bins(20);
    for (const ScanFigures& scan : *scans) {
      for (std::size_t i = 0; i < bins.size(); ++i) {
        bins[i].insert(bins[i].end(), scan.ground[i].begin(), scan.ground[i].end());
      }
    }
    panel.series.push_back(band(std::string(name) + ", 10 to 90 %", color, 0, 2.5, bins));
  }
  return panel;
}

const std::vector<io::KittiObject>& labels_of(const LabelFigures& figures,
                                              const std::string& type) {
  static const std::vector<io::KittiObject> kNone;
  const auto found = figures.objects.find(type);
  return found == figures.objects.end() ? kNone : found->second;
}

using Value = double (*)(const io::KittiObject&);

/// Shares of the labels of a class by a value of each.
Panel label_panel(const std::string& type, const std::string& axis, Value value, int bins,
                  double low, double high, const LabelFigures& real,
                  const LabelFigures& simulated) {
  Panel panel{.title = type, .x = {.label = axis}, .y = {.label = "share"}};
  for (const auto& [name, figures] : {std::pair{"real", &real}, {"simulated", &simulated}}) {
    std::vector<double> values;
    for (const io::KittiObject& object : labels_of(*figures, type)) values.push_back(value(object));
    const drawing::Bars counts = drawing::histogram(values, bins, name, low, high);
    drawing::Series series;
    series.name = name;
    for (std::size_t i = 0; i < counts.heights.size(); ++i) {
      series.x.push_back(0.5 * (counts.edges[i] + counts.edges[i + 1]));
      series.y.push_back(counts.heights[i] / std::max<double>(1, values.size()));
    }
    panel.series.push_back(series);
  }
  return panel;
}

template <class Count>
Panel bar_panel(const std::string& title, const std::string& axis,
                const std::vector<std::string>& categories, const Count& count,
                const LabelFigures& real, const LabelFigures& simulated) {
  Panel panel{.title = title, .y = {.label = axis}, .categories = categories};
  for (const auto& [name, figures] : {std::pair{"real", &real}, {"simulated", &simulated}}) {
    drawing::Bars bars{.name = name, .heights = {}};
    for (std::size_t i = 0; i < categories.size(); ++i) {
      bars.heights.push_back(count(*figures, i));
    }
    panel.bars.push_back(bars);
  }
  return panel;
}

}  // namespace

void draw_scans(const std::vector<ScanFigures>& real, const std::vector<ScanFigures>& simulated,
                const std::filesystem::path& file) {
  const auto panel = [&](const char* title, const char* axis, Select select, double step) {
    return scan_panel(title, axis, select, step, real, simulated);
  };
  std::vector<Panel> panels = {
      panel(
          "Range", "range, m", [](const ScanFigures& scan) { return scan.range; }, 1),
      panel(
          "Ring", "ring from the top", [](const ScanFigures& scan) { return scan.ring; }, 1),
      panel(
          "Intensity", "intensity", [](const ScanFigures& scan) { return scan.intensity; }, .05),
      panel(
          "Azimuth", "azimuth + 180, degrees", [](const ScanFigures& scan) { return scan.azimuth; },
          5)};
  panels[0].y.logarithmic = true;
  drawing::write_image(
      drawing::draw_figure(panels, {.title = "Real and simulated street scans", .columns = 2}),
      file);
}

void draw_objects(const std::vector<ScanFigures>& real, const std::vector<ScanFigures>& simulated,
                  const std::filesystem::path& file) {
  std::vector<Panel> panels;
  for (const char* type : {"Car", "Pedestrian", "Cyclist"}) {
    panels.push_back(points_panel(type, real, simulated));
  }
  panels.push_back(ground_panel(real, simulated));
  drawing::write_image(
      drawing::draw_figure(panels, {.title = "Points an object, and the ground", .columns = 2}),
      file);
}

void draw_labels(const LabelFigures& real, const LabelFigures& simulated,
                 const std::filesystem::path& file) {
  const std::vector<std::string> classes = {"Car", "Van", "Truck", "Pedestrian", "Cyclist"};
  const auto a_frame = [&](const LabelFigures& figures, std::size_t i) {
    return static_cast<double>(labels_of(figures, classes[i]).size()) / figures.frames;
  };
  const auto occluded = [](const LabelFigures& figures, std::size_t level) {
    double found = 0;
    const auto& cars = labels_of(figures, "Car");
    for (const io::KittiObject& car : cars) found += car.occlusion == static_cast<int>(level);
    return found / std::max<double>(1, cars.size());
  };
  const Value degrees = [](const io::KittiObject& object) {
    return heading(object) * 180 / std::numbers::pi;
  };
  const Value truncation = [](const io::KittiObject& object) { return object.truncation; };
  const std::vector<Panel> panels = {
      bar_panel("Labels a frame", "labels", classes, a_frame, real, simulated),
      label_panel("Car", "distance, m", &distance, 16, 0, 80, real, simulated),
      label_panel("Pedestrian", "distance, m", &distance, 16, 0, 80, real, simulated),
      bar_panel("Car, occlusion", "share", {"0", "1", "2", "unknown"}, occluded, real, simulated),
      label_panel("Car", "heading, degrees", degrees, 24, -180, 180, real, simulated),
      label_panel("Car", "truncation", truncation, 10, 0.01, 1, real, simulated)};
  drawing::write_image(
      drawing::draw_figure(panels, {.title = "Labels of real and simulated scans", .columns = 3}),
      file);
}

}  // namespace arbox::benchmarks
