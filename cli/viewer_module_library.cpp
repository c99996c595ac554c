#include <pcl/visualization/pcl_visualizer.h>
#include <vtkActor.h>
#include <vtkProperty.h>
#include <vtkRenderWindow.h>

// Xlib's macros break other headers: last.
#include <X11/Xlib.h>
#undef None
#undef Success
#undef Bool

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "arbox/cli/viewer_module.h"
#include "arbox/drawing/color.h"
#include "arbox/drawing/scene_page.h"
#include "arbox/geometry/quantile_box.h"

namespace arbox::cli {
namespace {

using geometry::Box;
using geometry::Detection;
using PointCloud = ::pcl::PointCloud<::pcl::PointXYZRGB>;
namespace view = ::pcl::visualization;

struct Shown {
  const Detection* detection;
  drawing::Color color;
  std::vector<geometry::QuantileBox> steps;
};

class Viewer {
 public:
  Viewer(const drawing::Scene& scene, const drawing::SceneOptions& options) : window_("Arbox") {
    const bool dark = options.background == drawing::Background::kDark;
    const double paper = dark ? 0.09 : 1.0;
    window_.setBackgroundColor(paper, paper, paper);
    show_cloud(scene.cloud, dark);
    for (std::size_t i = 0; i < scene.truth.size(); ++i) {
      draw(scene.truth[i].box, drawing::class_color(scene.truth[i].label),
           "truth " + std::to_string(i), 1, 0.5);
    }
    for (const Detection& detection : scene.predictions) {
      if (detection.score < options.minimum_score) continue;
      shown_.push_back(
          {&detection, drawing::class_color(detection.label), drawing::quantile_steps(detection)});
      for (const auto& step : shown_.back().steps) add_step(step.q);
      draw(detection.box, shown_.back().color, "box " + std::to_string(shown_.size()), 3, 1.0);
    }
    std::sort(quantiles_.begin(), quantiles_.end());
    present_ = quantiles_.size() / 2;
    window_.registerKeyboardCallback([this](const view::KeyboardEvent& event) { press(event); });
    place_camera(scene, options);
    show_quantile();
  }

  void run() {
    while (!window_.wasStopped()) window_.spinOnce(40);
  }

 private:
  void add_step(double q) {
    if (std::find(quantiles_.begin(), quantiles_.end(), q) == quantiles_.end()) {
      quantiles_.push_back(q);
    }
  }

  void show_cloud(const geometry::PointCloudView& cloud, bool dark) {
    auto points = ::pcl::make_shared<PointCloud>();
    std::vector<float> heights;
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      if (cloud.position(i).allFinite()) heights.push_back(cloud.position(i).z());
    }
    if (heights.empty()) return;
    std::sort(heights.begin(), heights.end());
    const float low = heights[heights.size() / 100], high = heights[heights.size() * 99 / 100];
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      const Eigen::Vector3f position = cloud.position(i);
      if (!position.allFinite()) continue;
      const drawing::Color color =
          drawing::map_color((position.z() - low) / std::max(high - low, 1e-3F), dark);
      points->emplace_back(position.x(), position.y(), position.z(), color.r, color.g, color.b);
    }
    window_.addPointCloud<::pcl::PointXYZRGB>(points, "cloud");
    window_.setPointCloudRenderingProperties(view::PCL_VISUALIZER_POINT_SIZE, 2, "cloud");
  }

  void draw(const Box& box, drawing::Color color, const std::string& name, double width,
            double opacity) {
    window_.addCube(box.center.cast<float>(), Eigen::Quaternionf(box.rotation.cast<float>()),
                    box.size.x(), box.size.y(), box.size.z(), name);
    window_.setShapeRenderingProperties(view::PCL_VISUALIZER_REPRESENTATION,
                                        view::PCL_VISUALIZER_REPRESENTATION_WIREFRAME, name);
    window_.setShapeRenderingProperties(view::PCL_VISUALIZER_COLOR, color.r / 255.0,
                                        color.g / 255.0, color.b / 255.0, name);
    vtkActor::SafeDownCast(window_.getShapeActorMap()->at(name))->GetProperty()->LightingOff();
    window_.setShapeRenderingProperties(view::PCL_VISUALIZER_LINE_WIDTH, width, name);
    window_.setShapeRenderingProperties(view::PCL_VISUALIZER_OPACITY, opacity, name);
  }

  /// The quantile boxes nearest to the present q, and the points that more than q of the samples
  /// hold.
  void show_quantile() {
    for (const std::string& name : drawn_) window_.removeShape(name);
    drawn_.clear();
    window_.removePointCloud("quantile");
    std::string title = "Arbox";
    if (!quantiles_.empty()) {
      const double q = quantiles_[present_];
      title += ": q = " + std::to_string(q).substr(0, 4);
      auto held = ::pcl::make_shared<PointCloud>();
      for (std::size_t i = 0; i < shown_.size(); ++i) show_quantile(shown_[i], q, i, *held);
      if (!held->empty()) {
        window_.addPointCloud<::pcl::PointXYZRGB>(held, "quantile");
        window_.setPointCloudRenderingProperties(view::PCL_VISUALIZER_POINT_SIZE, 2, "quantile");
      }
    }
    window_.getRenderWindow()->Render();
    window_.setWindowName(title + (samples_ ? ", samples" : ""));
  }

  void show_quantile(const Shown& one, double q, std::size_t number, PointCloud& held) {
    const auto nearest = std::min_element(
        one.steps.begin(), one.steps.end(),
        [q](const auto& a, const auto& b) { return std::abs(a.q - q) < std::abs(b.q - q); });
    const std::string name = " " + std::to_string(number);
    if (nearest != one.steps.end()) {
      drawn_.push_back("quantile" + name);
      draw(nearest->box, one.color, drawn_.back(), 1, 0.9);
    }
    const auto& samples = one.detection->samples;
    if (samples.empty()) return;
    for (const auto& point :
         geometry::occupancy_quantile({.boxes = samples}, q, {.points_per_box = 16})) {
      const Eigen::Vector3f p = point.cast<float>();
      held.emplace_back(p.x(), p.y(), p.z(), one.color.r, one.color.g, one.color.b);
    }
    if (samples_) show_samples(samples, one.color, "samples" + name);
  }

  /// All in one actor: a thousand would be slow.
  void show_samples(const std::vector<Box>& samples, drawing::Color color,
                    const std::string& name) {
    static constexpr std::uint32_t kFaces[6][4] = {{0, 1, 3, 2}, {4, 5, 7, 6}, {0, 1, 5, 4},
                                                   {2, 3, 7, 6}, {0, 2, 6, 4}, {1, 3, 7, 5}};
    ::pcl::PointCloud<::pcl::PointXYZ> corners;
    ::pcl::PolygonMesh mesh;
    for (const Box& sample : samples) {
      const auto first = static_cast<std::uint32_t>(corners.size());
      for (const Eigen::Vector3d& corner : geometry::corners(sample)) {
        corners.emplace_back().getVector3fMap() = corner.cast<float>();
      }
      for (const auto& face : kFaces) {
        auto& polygon = mesh.polygons.emplace_back().vertices;
        for (const std::uint32_t i : face) polygon.push_back(static_cast<int>(first + i));
      }
    }
    ::pcl::toPCLPointCloud2(corners, mesh.cloud);
    window_.addPolylineFromPolygonMesh(mesh, name);
    window_.setShapeRenderingProperties(view::PCL_VISUALIZER_COLOR, color.r / 255.0,
                                        color.g / 255.0, color.b / 255.0, name);
    drawn_.push_back(name);
  }

  void press(const view::KeyboardEvent& event) {
    if (!event.keyDown()) return;
    const std::string key = event.getKeySym();
    if (key == "k") {
      samples_ = !samples_;
    } else if (key == "n" && present_ + 1 < quantiles_.size()) {
      ++present_;
    } else if (key == "b" && present_ > 0) {
      --present_;
    } else {
      return;
    }
    show_quantile();
  }

  void place_camera(const drawing::Scene& scene, const drawing::SceneOptions& options) {
    Eigen::AlignedBox3d space;
    for (const auto* group : {&scene.truth, &scene.predictions}) {
      for (const Detection& detection : *group) space.extend(detection.box.center);
    }
    for (std::size_t i = 0; space.isEmpty() && i < scene.cloud.size(); ++i) {
      if (scene.cloud.position(i).allFinite()) space.extend(scene.cloud.position(i).cast<double>());
    }
    if (space.isEmpty()) space.extend(Eigen::Vector3d::Zero());
    const Eigen::Vector3d at = space.center();
    const double distance = 1.2 * space.sizes().norm() + 8.0;
    const double azimuth = options.azimuth * std::numbers::pi / 180.0;
    const double elevation = options.elevation.value_or(32.0) * std::numbers::pi / 180.0;
    const Eigen::Vector3d eye =
        at + distance * Eigen::Vector3d(std::cos(azimuth) * std::cos(elevation),
                                        std::sin(azimuth) * std::cos(elevation),
                                        std::sin(elevation));
    window_.setCameraPosition(eye.x(), eye.y(), eye.z(), at.x(), at.y(), at.z(), 0, 0, 1);
    window_.setCameraClipDistances(0.01 * distance, 100 * distance);
    window_.setSize(1280, 800);
  }

  view::PCLVisualizer window_;
  std::vector<Shown> shown_;
  std::vector<double> quantiles_;
  std::vector<std::string> drawn_;
  std::size_t present_ = 0;
  bool samples_ = false;
};

}  // namespace
}  // namespace arbox::cli

extern "C" __attribute__((visibility("default"))) bool arbox_view_interactively(
    const arbox::drawing::Scene& scene, const arbox::drawing::SceneOptions& options) {
  Display* display = ::XOpenDisplay(nullptr);
  if (display == nullptr) return false;
  ::XCloseDisplay(display);
  arbox::cli::Viewer(scene, options).run();
  return true;
}
