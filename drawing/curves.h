#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "arbox/drawing/color.h"
#include "arbox/drawing/image.h"

/// \file
/// Charts: lines, scatter, bars and histograms in one or several panels, for example precision over
/// recall, calibration, training losses. Nothing here opens a window.

namespace arbox::drawing {

enum class LineStyle { kSolid, kDashed, kDotted, kNone };

/// A line, a scatter of markers, or both.
struct Series {
  /// Entry of the legend; none if empty.
  std::string name;
  /// Coordinates, equally many; non-finite points (on a logarithmic axis also those <= 0) break the
  /// line and are not drawn.
  std::vector<double> x, y;
  LineStyle line = LineStyle::kSolid;
  bool markers = false;
  /// The next colour of the palette if not given.
  std::optional<Color> color = {};
  /// A pale band between these two, for example a confidence interval: both empty, or as long as x.
  std::vector<double> low = {}, high = {};
};

/// Bars of one colour: over categories (Panel::categories, one height each, bars of several groups
/// side by side) or a histogram (`edges` ascending, one longer than heights).
struct Bars {
  std::string name;
  std::vector<double> heights;
  std::vector<double> edges = {};
  std::optional<Color> color = {};
};

struct Axis {
  std::string label = {};
  /// Ends of the axis; from the data if not given.
  std::optional<double> low = {}, high = {};
  bool logarithmic = false;
};

/// One coordinate system. A panel without data shows empty axes.
struct Panel {
  std::string title = {};
  Axis x = {}, y = {};
  std::vector<Series> series = {};
  std::vector<Bars> bars = {};
  /// Names under groups of bars; the x axis then has no numbers.
  std::vector<std::string> categories = {};
  /// A dashed grey line y = x, what perfect calibration would give.
  bool diagonal = false;
  /// The legend in a row above the axes, for charts whose data fill them to the top.
  bool legend_above = false;
};

struct FigureOptions {
  std::string title = {};
  /// Panels side by side before a new row starts; 0 chooses (at most three).
  int columns = 0;
  /// Size of a panel with its axes and labels, pixels, each at least 120.
  int panel_width = 620;
  int panel_height = 460;
};

/// Draws the panels row by row. Equal input gives equal pixels.
///
/// Throws InvalidArgument, naming the panel and the series, for lengths that do not match, edges
/// that do not ascend, an axis whose low end is not below its high end or not positive where
/// logarithmic, no panel at all, and sizes out of range.
Image draw_figure(std::span<const Panel> panels, const FigureOptions& options = {});

/// Counts values (non-finite ones are left out) in `bins` >= 1 equal bins between their smallest
/// and largest, or between `low` and `high` where given; values outside are left out.
Bars histogram(std::span<const double> values, int bins, const std::string& name = {},
               std::optional<double> low = {}, std::optional<double> high = {});

}  // namespace arbox::drawing
