#include "arbox/drawing/scene.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "arbox/base/error.h"
#include "arbox/base/options.h"
#include "arbox/drawing/internal/projection.h"
#include "arbox/drawing/internal/scene_parts.h"

namespace arbox::drawing {
namespace {

void check(const Scene& scene, const SceneOptions& options) {
  validate_options(options, "draw_scene");
  for (const auto* group : {&scene.predictions, &scene.truth}) {
    for (const geometry::Detection& detection : *group) {
      geometry::require_valid(detection.box, "draw_scene");
      geometry::require_valid(detection.samples, "draw_scene: sample");
      for (const auto& quantile : detection.quantile_boxes) {
        geometry::require_valid(quantile.box, "draw_scene: quantile box");
      }
      for (const auto& confidence : detection.confidence_boxes) {
        geometry::require_valid(confidence.box, "draw_scene: confidence box");
      }
    }
  }
  if (scene.photo && !scene.photo->projection.allFinite()) {
    throw InvalidArgument("draw_scene: the photo's projection matrix must be finite");
  }
  const std::size_t fronts = scene.truth_has_front.size();
  if (fronts != 0 && fronts != scene.truth.size()) {
    throw InvalidArgument("draw_scene: truth_has_front must be empty or as long as truth");
  }
}

Image scaled(const Image& image, int width, int height) {
  Image result(width, height, {});
  const cv::Mat from(image.height, image.width, CV_8UC3,
                     const_cast<std::uint8_t*>(image.pixels.data()));
  cv::Mat to(height, width, CV_8UC3, result.pixels.data());
  cv::resize(from, to, to.size(), 0, 0, width < image.width ? cv::INTER_AREA : cv::INTER_CUBIC);
  return result;
}

void draw_photo(Canvas& canvas, const Scene& scene, SceneOptions options, const Rect& rect) {
  options.background = Background::kLight;
  Theme theme = make_theme(options);
  // What the photo shows behind is to be seen.
  theme.front_opacity = 0.1;
  const Photo& photo = *scene.photo;
  const int width = static_cast<int>(rect.width()), height = static_cast<int>(rect.height());
  canvas.paste(scaled(photo.image, width, height), static_cast<int>(rect.left),
               static_cast<int>(rect.top));
  // From the photo's pixels, whose centres are whole numbers, to the canvas'.
  const double sx = rect.width() / photo.image.width, sy = rect.height() / photo.image.height;
  Eigen::Matrix3d place;
  place << sx, 0, rect.left + 0.5 * sx, 0, sy, rect.top + 0.5 * sy, 0, 0, 1;
  const Projection projection = {place * photo.projection, 0.3};
  draw_boxes(canvas, theme, scene, projection, options.captions);
}

void draw_sensor(Canvas& canvas, const Theme& theme, const Region& region,
                 const Projection& projection) {
  if (!region.rings) return;
  if (const auto pixel = projection({0.0, 0.0, region.ground})) {
    canvas.disc(*pixel, 5.0 * theme.unit, theme.panel);
    canvas.disc(*pixel, 3.5 * theme.unit, theme.ink);
  }
}

void draw_birdseye(Canvas& canvas, const Theme& theme, const Scene& scene,
                   const ScenePoints& points, const Region& region, const SceneOptions& options,
                   const Rect& rect) {
  const Eigen::Vector3d extent = region.high - region.low;
  const double scale = std::min(rect.height() / extent.x(), rect.width() / extent.y());
  const Projection projection = birdseye_projection((region.low + region.high) / 2, scale, rect);
  canvas.fill(rect, theme.panel);
  draw_ground(canvas, theme, region, projection);
  draw_points_birdseye(canvas, theme, points, projection);
  draw_sensor(canvas, theme, region, projection);
  const auto taken = draw_furniture(canvas, theme, scene, projection, region.low, scale);
  draw_boxes(canvas, theme, scene, projection, options.captions, taken);
}

std::vector<Eigen::Vector3d> points_of_interest(const Scene& scene, const ScenePoints& points,
                                                const Region& region) {
  const Eigen::AlignedBox3d shown(region.low, region.high);
  std::vector<Eigen::Vector3d> result;
  const std::size_t step = std::max<std::size_t>(1, points.positions.size() / 4000);
  for (std::size_t i = 0; i < points.positions.size(); i += step) {
    const Eigen::Vector3d position = points.positions[i].cast<double>();
    if (shown.contains(position)) result.push_back(position);
  }
  for (const auto* group : {&scene.predictions, &scene.truth}) {
    for (const geometry::Detection& detection : *group) {
      for (const Eigen::Vector3d& corner : geometry::corners(detection.box)) {
        if (shown.contains(corner)) result.push_back(corner);
      }
    }
  }
  if (!result.empty()) return result;
  for (const double x : {region.low.x(), region.high.x()}) {
    for (const double y : {region.low.y(), region.high.y()})
      result.emplace_back(x, y, region.ground);
  }
  return result;
}

void draw_perspective(Canvas& canvas, const Theme& theme, const Scene& scene,
                      const ScenePoints& points, const Region& region, const SceneOptions& options,
                      const Rect& rect) {
  // One looks along a road, but over the walls into a room.
  const double elevation = options.elevation.value_or(region.rings ? 28.0 : 48.0);
  const Projection projection = perspective_projection(points_of_interest(scene, points, region),
                                                       options.azimuth, elevation, rect);
  canvas.fill(rect, theme.panel);
  draw_ground(canvas, theme, region, projection);
  draw_points_perspective(canvas, theme, points, region, projection);
  draw_sensor(canvas, theme, region, projection);
  const auto taken =
      draw_furniture(canvas, theme, scene, projection, (region.low + region.high) / 2);
  draw_boxes(canvas, theme, scene, projection, options.captions, taken);
}

struct Layout {
  int height;
  Rect title, photo, birdseye, perspective, legend;
};

Layout lay_out(const Scene& scene, const SceneOptions& options, const Theme& theme,
               const ScenePoints& points, const Region& region) {
  const double gap = std::round(10.0 * theme.unit), width = options.width;
  const double left = gap, right = width - gap;
  Layout layout = {};
  double y = gap;
  if (!options.title.empty()) {
    layout.title = {left, y, right, y + std::round(34.0 * theme.unit)};
    y = layout.title.bottom + gap;
  }
  if (scene.photo) {
    const double height =
        std::round((right - left) * scene.photo->image.height / scene.photo->image.width);
    layout.photo = {left, y, right, y + height};
    y = layout.photo.bottom + gap;
  }
  const double legend = std::round(legend_height(theme, scene, points, right - left));
  const double below = legend > 0.0 ? legend + 2.0 * gap : gap;
  const bool birdseye = options.view != SceneView::kPerspective,
             perspective = options.view != SceneView::kBirdseye;
  const Eigen::Vector3d extent = region.high - region.low;
  const double aspect =
      std::clamp(extent.y() / extent.x(), 0.6, birdseye && perspective ? 1.2 : 3.0);
  double height = 0.0;
  if (birdseye && perspective) {
    height = std::round(width * std::clamp(0.78 / (aspect + 0.8), 0.38, 0.52));
  } else {
    height = std::round(birdseye ? (right - left) / std::max(1.0, aspect) : 0.6 * width);
  }
  if (options.height > 0) height = options.height - y - below;
  if (height < 120.0 * theme.unit) {
    throw InvalidArgument("draw_scene: height must be 0 or at least " +
                          std::to_string(static_cast<int>(y + below + 120.0 * theme.unit) + 1) +
                          " pixels for this content, got " + std::to_string(options.height));
  }
  const double middle = birdseye && perspective
                            ? std::round(left + std::min(height * aspect, 0.6 * (right - left)))
                            : (birdseye ? right : left);
  if (birdseye) layout.birdseye = {left, y, middle, y + height};
  if (perspective) {
    layout.perspective = {birdseye ? middle + gap : left, y, right, y + height};
  }
  layout.legend = {left, y + height + gap, right, y + height + gap + legend};
  layout.height = static_cast<int>(y + height + below);
  return layout;
}

}  // namespace

Theme make_theme(const SceneOptions& options) {
  const double unit = std::clamp(options.width / 1600.0, 0.55, 4.0);
  if (options.background == Background::kDark) {
    return {true, {14, 17, 22}, {22, 26, 33}, {235, 238, 242}, {165, 172, 182}, {58, 66, 78}, unit};
  }
  return {false, {255, 255, 255}, {247, 248, 250}, {28, 30, 34}, {105, 110, 118}, {208, 213, 220},
          unit};
}

Color theme_color(const Theme& theme, const std::string& label) {
  const Color color = class_color(label);
  return theme.dark ? mix(color, theme.ink, 0.15) : color;
}

Image draw_scene(const Scene& given, const SceneOptions& options) {
  check(given, options);
  Scene scene = given;
  std::erase_if(scene.predictions, [&](const geometry::Detection& detection) {
    return detection.score < options.minimum_score;
  });
  if (scene.photo && scene.photo->image.empty()) scene.photo.reset();
  const Theme theme = make_theme(options);
  const ScenePoints points = collect_points(scene.cloud, options);
  const Region region = find_region(points, scene, options);
  const Layout layout = lay_out(scene, options, theme, points, region);
  Canvas canvas(options.width, layout.height, theme.paper);
  canvas.text(layout.title.center(), options.title,
              {.size = 19.0 * theme.unit,
               .color = theme.ink,
               .bold = true,
               .along = Align::kMiddle,
               .across = Align::kMiddle});
  const auto within = [&](const Rect& rect, const auto& draw) {
    if (rect.width() <= 0.0) return;
    canvas.clip(rect);
    draw(rect);
    canvas.clip_to_all();
  };
  within(layout.photo, [&](const Rect& rect) { draw_photo(canvas, scene, options, rect); });
  within(layout.birdseye, [&](const Rect& rect) {
    draw_birdseye(canvas, theme, scene, points, region, options, rect);
  });
  within(layout.perspective, [&](const Rect& rect) {
    draw_perspective(canvas, theme, scene, points, region, options, rect);
  });
  within(layout.legend, [&](const Rect& rect) { draw_legend(canvas, theme, scene, points, rect); });
  return canvas.take();
}

}  // namespace arbox::drawing
