#include "arbox/drawing/scene_page.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "arbox/base/error.h"
#include "arbox/base/options.h"
#include "arbox/drawing/internal/scene_parts.h"
#include "arbox/geometry/quantile_box.h"
#include "arbox/io/json.h"

namespace arbox::drawing {

/// scene_page.html, compiled in.
extern const char* const kScenePage;

namespace {

using geometry::Box;
using geometry::Detection;
using io::Json;

constexpr char kDataMark[] = "ARBOX_SCENE";

std::string base64(const std::string& bytes) {
  static constexpr char kDigits[] =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t group = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      group = group << 8 | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0U);
    }
    for (std::size_t k = 0; k < 4; ++k) {
      text += i + k <= bytes.size() ? kDigits[group >> (18 - 6 * k) & 63] : '=';
    }
  }
  return text;
}

std::string css(Color color) {
  static constexpr char kHex[] = "0123456789abcdef";
  std::string text = "#";
  for (const std::uint8_t byte : {color.r, color.g, color.b}) {
    text += kHex[byte >> 4];
    text += kHex[byte & 15];
  }
  return text;
}

double rounded(double value, double step) { return std::round(value / step) * step; }

std::string shown(double value) {
  std::string text = std::to_string(rounded(value, 0.001));
  return text.substr(0, text.find('.') + 4);
}

Json numbers(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

/// The eight corners, one after another.
Json corners_json(const Box& box) {
  Json list = Json::array();
  for (const Eigen::Vector3d& corner : geometry::corners(box)) {
    for (const double coordinate : corner) list.push_back(rounded(coordinate, 1e-4));
  }
  return list;
}

/// Positions as 3 x uint16 within the extent and colours as 3 bytes, 9 bytes a point.
Json points_json(const ScenePoints& points, std::size_t most) {
  const std::size_t step = std::max<std::size_t>(1, (points.positions.size() + most - 1) / most);
  Eigen::AlignedBox3f extent;
  for (const Eigen::Vector3f& position : points.positions) extent.extend(position);
  const Eigen::Vector3f low = extent.isEmpty() ? Eigen::Vector3f::Zero().eval() : extent.min();
  const Eigen::Vector3f size =
      extent.isEmpty() ? Eigen::Vector3f::Ones().eval() : extent.sizes().cwiseMax(1e-6F).eval();
  std::string bytes;
  std::size_t count = 0;
  for (std::size_t i = 0; i < points.positions.size(); i += step, ++count) {
    for (int axis = 0; axis < 3; ++axis) {
      const double share = (points.positions[i][axis] - low[axis]) / size[axis];
      const auto number = static_cast<std::uint16_t>(std::lround(65535.0 * share));
      bytes += static_cast<char>(number & 255);
      bytes += static_cast<char>(number >> 8);
    }
    const Color color = points.colors[i];
    for (const std::uint8_t byte : {color.r, color.g, color.b}) bytes += static_cast<char>(byte);
  }
  return {{"count", count},
          {"of", points.positions.size()},
          {"low", numbers(low.cast<double>())},
          {"size", numbers(size.cast<double>())},
          {"quantity", points.quantity},
          {"data", base64(bytes)}};
}

std::string size_text(const Eigen::Vector3d& size) {
  return shown(size.x()) + " \xC3\x97 " + shown(size.y()) + " \xC3\x97 " + shown(size.z()) + " m";
}

/// What stands under the pointer: rows of name and value.
Json details_of(const Detection& detection, bool truth) {
  const Box& box = detection.box;
  Json rows = Json::array();
  const auto row = [&](const char* name, const std::string& value) {
    rows.push_back({name, value});
  };
  if (!truth) row("score", shown(detection.score));
  row("centre",
      shown(box.center.x()) + ", " + shown(box.center.y()) + ", " + shown(box.center.z()) + " m");
  row("size", size_text(box.size));
  row("yaw", shown(geometry::yaw(box)) + " rad");
  if (detection.uncertainty) row("uncertainty", shown(*detection.uncertainty));
  if (detection.log_density) row("log density", shown(*detection.log_density));
  if (detection.known_size) {
    const auto& [name, size] = *detection.known_size;
    row("known size", (name.empty() ? "" : name + ", ") + size_text(size));
  }
  if (!detection.samples.empty()) row("samples", std::to_string(detection.samples.size()));
  return rows;
}

Json box_json(const Detection& detection, const Theme& theme, bool truth) {
  Json object = {{"class", detection.label},
                 {"truth", truth},
                 {"color", css(theme_color(theme, detection.label))},
                 {"corners", corners_json(detection.box)},
                 {"details", details_of(detection, truth)}};
  if (truth) return object;
  Json& quantiles = object["quantiles"] = Json::array();
  for (const auto& [q, box, fallback] : quantile_steps(detection)) {
    quantiles.push_back({{"q", q},
                         {"corners", corners_json(box)},
                         {"size", numbers(box.size)},
                         {"fallback", fallback}});
  }
  Json& confidences = object["confidences"] = Json::array();
  for (const auto& [p, box] : detection.confidence_boxes) {
    confidences.push_back({{"p", p}, {"corners", corners_json(box)}, {"size", numbers(box.size)}});
  }
  return object;
}

Json boxes_json(const Scene& scene, const SceneOptions& options, const Theme& theme) {
  Json boxes = Json::array();
  for (const Detection& detection : scene.truth) {
    geometry::require_valid(detection.box, "scene_page: truth");
    boxes.push_back(box_json(detection, theme, true));
  }
  for (const Detection& detection : scene.predictions) {
    geometry::require_valid(detection.box, "scene_page: predictions");
    if (detection.score < options.minimum_score) continue;
    boxes.push_back(box_json(detection, theme, false));
  }
  return boxes;
}

}  // namespace

std::vector<geometry::QuantileBox> quantile_steps(const Detection& detection) {
  std::vector<geometry::QuantileBox> boxes = detection.quantile_boxes;
  if (!detection.samples.empty()) {
    std::vector<double> qs;
    for (int i = 1; i < 20; ++i) qs.push_back(i / 20.0);
    boxes = geometry::quantile_boxes(detection.samples, qs);
  }
  std::sort(boxes.begin(), boxes.end(), [](const auto& a, const auto& b) { return a.q < b.q; });
  return boxes;
}

std::string scene_page(const Scene& scene, const SceneOptions& options, std::size_t most_points) {
  validate_options(options, "scene_page");
  if (most_points == 0) throw InvalidArgument("scene_page: expected at least one point, got 0");
  const Theme theme = make_theme(options);
  const ScenePoints points = collect_points(scene.cloud, options);
  const Region region = find_region(points, scene, options);
  const Json data = {{"title", options.title},
                     {"paper", css(theme.paper)},
                     {"ink", css(theme.ink)},
                     {"grid", css(theme.grid)},
                     {"captions", options.captions},
                     {"low", numbers(region.low)},
                     {"high", numbers(region.high)},
                     {"ground", region.ground},
                     {"azimuth", options.azimuth},
                     {"elevation", options.elevation.value_or(32.0)},
                     {"points", points_json(points, most_points)},
                     {"boxes", boxes_json(scene, options, theme)}};
  std::string text = io::dump_json(data, -1);
  // "</script>" and "<!--" must not appear in a script.
  for (std::size_t at = text.find('<'); at != std::string::npos; at = text.find('<', at)) {
    text.replace(at, 1, "\\u003c");
  }
  std::string page = kScenePage;
  return page.replace(page.find(kDataMark), sizeof(kDataMark) - 1, text);
}

}  // namespace arbox::drawing
