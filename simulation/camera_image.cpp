#include "arbox/simulation/camera_image.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "arbox/base/options.h"
#include "arbox/simulation/internal/daylight.h"
#include "arbox/simulation/internal/projector.h"
#include "arbox/simulation/internal/surface_colors.h"
#include "arbox/simulation/ray_tracer.h"

namespace arbox::simulation {
namespace {

constexpr double kReferenceTime = 0.5;
constexpr double kNearest = 0.3, kFarthest = 400.0;
constexpr double kPlate = 0.07;  // a number plate's depth, metres
constexpr double kLift = 4e-3;   // of secondary rays above their surface, metres
constexpr double kFold = 0.02;   // nearer surfaces throw no shadow, metres
constexpr double kShadowReach = 120.0;
constexpr double kCrevice = 1.6;  // metres; what is nearer takes sky light away
constexpr float kCreviceLight = 0.42f;
constexpr int kMostPanes = 6;
constexpr float kPaneTransmittance = 0.55f;

struct Ray {
  Eigen::Vector3d origin, direction;
  int number = 0;  // of the pixel's rays
};

/// The share of light that a smooth surface reflects, less than flat faces would at grazing angles.
double reflected_share(double cosine, double normal_incidence) {
  return normal_incidence + 0.5 * std::pow(1.0 - cosine, 5.0);
}

bool is_glossy(Material material) {
  return material == Material::kPaintLight || material == Material::kPaintDark;
}

class Renderer {
 public:
  explicit Renderer(const Scene& scene)
      : scene_(scene), tracer_(scene, 0.0), colors_(scene), day_(draw_daylight(scene.seed)) {}

  /// The light along the ray; `object` is what it meets first, or -1.
  Rgb light(const Ray& ray, std::int32_t& object) const {
    Rgb sum = Rgb::Zero(), share = Rgb::Ones();
    double from = kNearest, hazy_from = 0.0;
    object = -1;
    Hit hit;
    for (int surface = 0; surface < kMostPanes; ++surface) {
      if (!tracer_.trace(ray.origin, ray.direction, kReferenceTime, from, kFarthest, hit)) break;
      if (surface == 0) object = hit.object;
      if (is_glossy(hit.material)) look_for_plate(ray, hit);
      const double air = hit.distance - hazy_from;
      const bool pane = hit.material == Material::kGlass;
      const Rgb here = pane ? reflection(ray.direction, hit, 0.08) : surface_light(ray, hit);
      sum += share * through_haze(day_, here, air);
      if (!pane) return sum;
      share *= kPaneTransmittance * Rgb(0.86f, 0.97f, 0.93f);
      from = hit.distance + 1e-3;
      hazy_from = hit.distance;
    }
    return sum + share * background(ray);
  }

 private:
  /// Number plates lie in the plane of the bumper: the plate counts, not the paint.
  void look_for_plate(const Ray& ray, Hit& hit) const {
    if (hit.object < 0) return;
    const geometry::Box& box = scene_.objects[static_cast<std::size_t>(hit.object)].box;
    const Eigen::Vector3d point = ray.origin + hit.distance * ray.direction;
    const double along = (box.rotation.conjugate() * (point - box.center)).x();
    if (std::abs(along) < 0.5 * box.size.x() - 5e-3) return;
    Hit behind;
    if (tracer_.trace(ray.origin, ray.direction, kReferenceTime, hit.distance + 1e-3,
                      hit.distance + 2.0 * kPlate, behind) &&
        behind.object == hit.object && behind.material == Material::kRetroreflector) {
      hit.material = behind.material;
    }
  }

  Rgb reflection(const Eigen::Vector3d& direction, const Hit& hit, double normal_incidence) const {
    const double cosine = -direction.dot(hit.normal);
    const Eigen::Vector3d mirrored = direction + 2.0 * cosine * hit.normal;
    const auto sky = static_cast<float>(std::clamp(0.5 + 3.0 * mirrored.z(), 0.0, 1.0));
    const Rgb seen = sky * day_.sky(mirrored) + (1.0f - sky) * day_.bounce;
    return static_cast<float>(reflected_share(cosine, normal_incidence)) * seen;
  }

  Rgb surface_light(const Ray& ray, const Hit& hit) const {
    const Eigen::Vector3d point = ray.origin + hit.distance * ray.direction;
    const Eigen::Vector3d start = point + kLift * hit.normal;
    const bool leaf = hit.material == Material::kFoliage;
    const double facing = hit.normal.dot(day_.sun);
    const double cosine = leaf ? 0.30 + 0.70 * std::abs(facing) : std::max(0.0, facing);
    Rgb incoming = day_.ambient(leaf ? Eigen::Vector3d::UnitZ().eval() : hit.normal);
    if (tracer_.blocked(start, skyward(hit.normal, ray.number), kReferenceTime, kFold, kCrevice)) {
      incoming *= kCreviceLight;
    }
    if (cosine > 0.0 && !tracer_.blocked(start, day_.sun, kReferenceTime, kFold, kShadowReach)) {
      incoming += static_cast<float>(cosine) * day_.sun_light;
    }
    const Rgb diffuse = colors_.color(hit, point) * incoming;
    return is_glossy(hit.material) ? diffuse + reflection(ray.direction, hit, 0.04) : diffuse;
  }

  /// Directions about the normal that the rays of a pixel take in turn.
  static Eigen::Vector3d skyward(const Eigen::Vector3d& normal, int number) {
    const double angle = 0.6 + number * std::numbers::pi * (3.0 - std::sqrt(5.0));
    const Eigen::Vector3d aside(std::cos(angle), std::sin(angle), 0.5);
    return (normal + 0.8 * aside.normalized()).normalized();
  }

  /// Land as far as the eye reaches, and the sky.
  Rgb background(const Ray& ray) const {
    const double fall = -scene_.ground_normal.dot(ray.direction);
    if (fall <= 1e-3) return day_.sky(ray.direction);
    const double height = scene_.ground_normal.dot(ray.origin) + scene_.ground_offset;
    static const Rgb land = from_srgb(92, 112, 64);
    const Rgb lit = land * (day_.ambient(scene_.ground_normal) + 0.5f * day_.sun_light);
    return through_haze(day_, lit, std::max(0.0, height) / fall);
  }

  const Scene& scene_;
  const RayTracer tracer_;
  const SurfaceColors colors_;
  const Daylight day_;
};

}  // namespace

CameraImage render_camera_image(const Scene& scene, const CameraView& camera,
                                const CameraImageOptions& options) {
  validate_options(options, "camera image options");
  const int width = camera.image.width, height = camera.image.height;
  CameraImage result{drawing::Image(width, height, {}), {}};
  result.objects.reserve(static_cast<std::size_t>(width) * height);
  const Renderer renderer(scene);
  const Projector projector = projector_of(camera);
  const int side = options.samples, rays = side * side;
  std::size_t place = 0;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      Rgb sum = Rgb::Zero();
      for (int ray = 0; ray < rays; ++ray) {
        const Eigen::Vector3d pixel(x - 0.5 + (ray % side + 0.5) / side,
                                    y - 0.5 + (ray / side + 0.5) / side, 1.0);
        std::int32_t object = -1;
        sum +=
            renderer.light({projector.center, (projector.back * pixel).normalized(), ray}, object);
        if (ray == 0) result.objects.push_back(object);
      }
      const auto color = exposed(sum / static_cast<float>(rays));
      std::copy_n(color.data(), 3, result.picture.pixels.begin() + static_cast<long>(place));
      place += 3;
    }
  }
  return result;
}

}  // namespace arbox::simulation
