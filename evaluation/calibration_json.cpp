#include <cmath>
#include <limits>

#include "arbox/base/error.h"
#include "arbox/evaluation/confidence_calibration.h"
#include "arbox/io/json.h"

namespace arbox::evaluation {
namespace {

using io::Json;
using io::JsonCursor;

constexpr char kFormat[] = "arbox confidence calibration";
constexpr int kVersion = 1;

Json to_value(const geometry::QuantileOptions& options) {
  return {{"points_per_box", options.points_per_box},
          {"placement", options.placement},
          {"corners", options.corners},
          {"refine", options.refine},
          {"seed", options.seed}};
}

template <class Integer>
Integer whole_number(const JsonCursor& value, double low) {
  const double number = value.number();
  if (number < low || number != std::floor(number) || number > 9007199254740992.0) {
    value.refuse("a whole number from " + std::to_string(static_cast<int>(low)));
  }
  return static_cast<Integer>(number);
}

geometry::QuantileOptions read_quantile_box(const JsonCursor& value) {
  value.require_object({"points_per_box", "placement", "corners", "refine", "seed"});
  geometry::QuantileOptions options;
  options.points_per_box = whole_number<int>(value.at("points_per_box"), 0);
  options.placement = value.at("placement").text();
  options.corners = value.at("corners").boolean();
  options.refine = value.at("refine").boolean();
  options.seed = whole_number<std::uint64_t>(value.at("seed"), 0);
  return options;
}

ExtentCount read_extent(const JsonCursor& value, double above) {
  const auto pair = value.elements();
  if (pair.size() != 2) value.refuse("a pair of extent and count");
  const double extent = pair[0].number();
  if (!(extent > above && std::isfinite(extent))) pair[0].refuse("extents above 0 that rise");
  return {.extent = extent, .count = whole_number<std::int64_t>(pair[1], 1)};
}

std::vector<ExtentCount> read_class(const JsonCursor& value) {
  value.require_object({"extents", "uncontained"});
  std::vector<ExtentCount> extents;
  for (const JsonCursor& pair : value.at("extents").elements()) {
    extents.push_back(read_extent(pair, extents.empty() ? 0.0 : extents.back().extent));
  }
  const auto uncontained = whole_number<std::int64_t>(value.at("uncontained"), 0);
  if (uncontained > 0) extents.push_back({std::numeric_limits<double>::infinity(), uncontained});
  return extents;
}

}  // namespace

std::string to_json(const ConfidenceCalibration& calibration) {
  Json json = {{"format", kFormat},
               {"version", kVersion},
               {"source", calibration.source},
               {"min_iog", calibration.min_iog},
               {"quantiles", calibration.family.quantiles},
               {"quantile_box", to_value(calibration.family.quantile_box)},
               {"classes", Json::object()}};
  for (const auto& [label, extents] : calibration.classes) {
    Json& of_class = json["classes"][label];
    of_class = {{"extents", Json::array()}, {"uncontained", 0}};
    for (const ExtentCount& entry : extents) {
      if (std::isfinite(entry.extent)) {
        of_class["extents"].push_back({entry.extent, entry.count});
      } else {
        of_class["uncontained"] = entry.count;
      }
    }
  }
  return io::dump_json(json, 1) + "\n";
}

ConfidenceCalibration parse_confidence_calibration(std::string_view text, std::string_view source) {
  const auto values = io::parse_json_values(text, source);
  if (values.size() != 1) {
    throw FormatError(std::string(source) + ": expected one JSON object, got " +
                      std::to_string(values.size()) + " values");
  }
  const JsonCursor root(values[0], std::string(source));
  root.require_object(
      {"format", "version", "source", "min_iog", "quantiles", "quantile_box", "classes"});
  if (root.at("format").text() != kFormat) root.at("format").refuse(kFormat);
  if (root.at("version").number() != kVersion) root.at("version").refuse("version 1");
  ConfidenceCalibration calibration;
  calibration.source = root.at("source").text();
  calibration.min_iog = root.at("min_iog").number();
  if (!(calibration.min_iog >= 0.0 && calibration.min_iog < 1.0)) {
    root.at("min_iog").refuse("a share in [0, 1)");
  }
  calibration.family.quantiles.clear();
  for (const JsonCursor& q : root.at("quantiles").elements()) {
    calibration.family.quantiles.push_back(q.number());
  }
  try {
    require_valid(calibration.family);
  } catch (const InvalidArgument&) {
    root.at("quantiles").refuse("numbers below 1 that fall strictly and end with 0");
  }
  calibration.family.quantile_box = read_quantile_box(root.at("quantile_box"));
  const JsonCursor classes = root.at("classes");
  classes.require_object();
  for (const auto& [label, ignored] : values[0].at("classes").items()) {
    calibration.classes[label] = read_class(classes.at(label.c_str()));
  }
  return calibration;
}

}  // namespace arbox::evaluation
