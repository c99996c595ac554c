#include "arbox/simulation/lidar_scan.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "arbox/base/random.h"

namespace arbox::simulation {
namespace {

constexpr double kTurn = 2.0 * std::numbers::pi;
constexpr int kMostSurfaces = 8;
/// What a pane of tinted glass lets through and back.
constexpr double kPaneTransmittance = 0.20;

enum Purpose : std::uint32_t { kSteps = 100, kPulse = 101 };

/// Draws of one pulse, numbered so that adding one does not shift the others.
enum Draw : std::uint32_t {
  kRangeNoise,
  kSignal,
  kDropout,
  kReflectivity,
  kSpurious,
  kSpuriousLength,
  kIntensityNoise,
  kZero,
  kOwnVehicle,
  kSurface,  // and one for each further surface
};

struct Pulse {
  Eigen::Vector3d origin, direction;  // scanner's frame
  double azimuth;                     // [0, 2 pi)
};

Pulse pulse_of(const LidarBeam& beam, double encoder) {
  const double theta = encoder + beam.azimuth_offset;
  const double s = std::sin(theta), c = std::cos(theta);
  const double xy = -beam.vertical_offset * std::sin(beam.elevation);
  return {.origin = {xy * c - beam.horizontal_offset * s, xy * s + beam.horizontal_offset * c,
                     beam.vertical_offset * std::cos(beam.elevation)},
          .direction = {std::cos(beam.elevation) * c, std::cos(beam.elevation) * s,
                        std::sin(beam.elevation)},
          .azimuth = theta - kTurn * std::floor(theta / kTurn)};
}

Eigen::Isometry3d scanner_pose(const EgoMotion& ego, double seconds) {
  const double angle = ego.yaw_rate * seconds;
  const double distance = ego.speed * seconds;
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() = Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  pose.translation() << distance * std::cos(0.5 * angle), distance * std::sin(0.5 * angle), 0.0;
  return pose;
}

std::vector<double> encoder_angles(const LidarModel& model, std::uint64_t seed) {
  const RandomStream random(seed, 0, kSteps);
  std::vector<double> angles;
  std::uint32_t draw = 0;
  for (int tick = 0; tick < model.ticks;) {
    angles.push_back(std::numbers::pi - kTurn * tick / model.ticks);
    tick += random.uniform(draw++) < model.double_step_share ? 2 : 1;
  }
  return angles;
}

bool hidden(const LidarBeam& beam, double azimuth) {
  return std::any_of(beam.hidden.begin(), beam.hidden.end(), [&](const auto& range) {
    return azimuth >= range.first && azimuth < range.second;
  });
}

double rounded(double value, double step) {
  return step > 0.0 ? std::round(value / step) * step : value;
}

/// How much of the diffuse reflectivity is left at a cosine of incidence: nearly flat, as measured
/// on walls.
double incidence_gain(double cosine) { return std::min(1.0, 0.58 + 1.05 * cosine); }

/// How reported intensity falls with range although the sensor adapts its power.
double range_gain(double range) { return std::clamp(1.35 - 0.015 * range, 0.3, 1.0); }

double intensity_floor(double range) { return std::clamp(0.0045 * (range - 15.0), 0.0, 0.18); }

/// Chance that a return is reported with intensity 0 although its range is good: weak returns
/// mostly, strong ones now and then.
double zero_chance(double intensity) { return 0.03 + 0.92 * std::exp(-intensity / 0.07); }

/// What is left of the reflectivity when a glossy surface is met at an angle.
double gloss_gain(double gloss, double cosine) {
  const double squared = cosine * cosine;
  return 1.0 - gloss + gloss * squared * squared * squared;
}

/// Follows the pulse through transparent surfaces. False if nothing comes back.
bool follow(const RayTracer& tracer, const LidarModel& model, const Eigen::Vector3d& origin,
            const Eigen::Vector3d& direction, double time, const RandomStream& random, bool ideal,
            Hit& hit, double& through) {
  double nearest = model.nearest;
  through = 1.0;
  for (int surface = 0; surface < kMostSurfaces; ++surface) {
    if (!tracer.trace(origin, direction, time, nearest, model.farthest, hit)) return false;
    if (ideal) return true;
    const MaterialProperties& material = properties(hit.material);
    const double draw = random.uniform(kSurface + static_cast<std::uint32_t>(surface));
    if (draw >= material.transmission) return draw >= material.transmission + material.loss;
    nearest = hit.distance + 1e-3;
    through *= kPaneTransmittance;
  }
  return false;
}

/// Reflectivity of this return, or a negative number if the return is lost.
double received(const LidarModel& model, const LidarBeam& beam, const Hit& hit, double cosine,
                double through, const RandomStream& random) {
  const MaterialProperties& material = properties(hit.material);
  const double brightness = takes_brightness(hit.material) ? hit.brightness : 1.0;
  const double reflectivity = std::max(
      0.004, (material.reflectivity + 0.35 * material.spread * random.normal(kReflectivity)) *
                 brightness * gloss_gain(material.gloss, cosine) * through);
  const double range = hit.distance;
  const double signal = reflectivity * std::max(cosine, 0.01) / (range * range);
  const double kept = 1.0 / (1.0 + std::pow(model.half_signal / signal, model.signal_sharpness));
  const double slant = (1.0 - cosine) * (1.0 - cosine);
  const double grazing =
      std::min(0.15, 0.0042 / std::max(cosine, 0.02)) + 0.30 * material.gloss * slant * slant;
  if (random.uniform(kSignal) > kept) return -1.0;
  if (random.uniform(kDropout) < model.dropout + model.dropout_growth * range + grazing) {
    return -1.0;
  }
  const double gain = beam.gain * (1.0 + 0.12 * random.normal(kIntensityNoise));
  const double intensity =
      std::max(0.0, reflectivity * gain * incidence_gain(cosine) * range_gain(range) -
                        intensity_floor(range));
  return random.uniform(kZero) < zero_chance(intensity) ? 0.0 : intensity;
}

double measured_range(const LidarModel& model, const LidarBeam& beam, const Hit& hit, double cosine,
                      double intensity, const RandomStream& random) {
  double sigma = model.range_noise + model.range_noise_growth * hit.distance;
  sigma *= 1.0 + 0.6 * (1.0 - std::min(1.0, intensity / 0.3)) + 0.5 * (1.0 - cosine);
  double range = hit.distance + beam.range_bias + sigma * random.normal(kRangeNoise);
  if (random.uniform(kSpurious) < model.spurious) {
    range += 0.3 + 0.4 * hit.distance * random.uniform(kSpuriousLength);
  }
  return rounded(range, model.range_step);
}

/// Distance at which the own vehicle returns this pulse, or 0.
double own_range(const LidarModel& model, const LidarBeam& beam, double azimuth,
                 const RandomStream& random) {
  for (const OwnReturn& own : beam.own) {
    if (azimuth < own.begin || azimuth >= own.end) continue;
    if (random.uniform(kOwnVehicle) >= own.chance) return 0.0;
    const double range = own.range + own.spread * random.normal(kRangeNoise);
    return std::max(model.nearest, rounded(range, model.range_step));
  }
  return 0.0;
}

/// What comes back of a pulse, and from where.
struct Echo {
  Hit hit;
  double range = 0.0, intensity = 0.0;
};

/// False if the scene returns nothing.
bool echo_of(const RayTracer& tracer, const LidarModel& model, const LidarBeam& beam,
             const Eigen::Vector3d& origin, const Eigen::Vector3d& direction, double time,
             const RandomStream& random, bool ideal, Echo& echo) {
  double through = 1.0;
  if (!follow(tracer, model, origin, direction, time, random, ideal, echo.hit, through)) {
    return false;
  }
  echo.range = echo.hit.distance;
  echo.intensity = properties(echo.hit.material).reflectivity;
  if (ideal) return true;
  const double cosine = std::abs(echo.hit.normal.dot(direction));
  echo.intensity = received(model, beam, echo.hit, cosine, through, random);
  if (echo.intensity < 0.0) return false;
  echo.range = measured_range(model, beam, echo.hit, cosine, echo.intensity, random);
  return echo.range >= model.nearest && echo.range < model.farthest;
}

/// The box at `seconds` from the reference time.
geometry::Box box_at(const SceneObject& object, const EgoMotion& ego, double seconds,
                     bool compensated) {
  geometry::Box box = object.box;
  box.center += seconds * object.velocity;
  if (compensated) return box;
  const Eigen::Isometry3d to_scanner = scanner_pose(ego, seconds).inverse();
  box.center = to_scanner * box.center;
  box.rotation = Eigen::Quaterniond(to_scanner.linear()) * box.rotation;
  return box;
}

/// Seconds from the reference time to the moment when the scanner faces the middle of the object:
/// the head's azimuth falls at a constant rate, the object's changes little meanwhile.
double time_faced(const SceneObject& object, const EgoMotion& ego, double duration) {
  constexpr int kIterations = 4;
  const Eigen::Vector3d& start = object.box.center;
  const double first = std::atan2(start.y(), start.x());
  double seconds = -first / kTurn * duration;
  for (int i = 0; i < kIterations; ++i) {
    const Eigen::Vector3d center = box_at(object, ego, seconds, false).center;
    const double turned = std::remainder(std::atan2(center.y(), center.x()) - first, kTurn);
    seconds = std::clamp(-(first + turned) / kTurn * duration, -0.5 * duration, 0.5 * duration);
  }
  return seconds;
}

}  // namespace

std::vector<geometry::Box> scanned_boxes(const Scene& scene, const LidarModel& model,
                                         const LidarOptions& options) {
  std::vector<geometry::Box> boxes;
  for (const SceneObject& object : scene.objects) {
    const double seconds = time_faced(object, scene.ego, model.duration);
    boxes.push_back(box_at(object, scene.ego, seconds, options.motion_compensated));
  }
  return boxes;
}

std::vector<LidarReturn> scan(const Scene& scene, const RayTracer& tracer, const LidarModel& model,
                              const LidarOptions& options) {
  const std::vector<double> angles = encoder_angles(model, scene.seed);
  std::vector<Eigen::Isometry3d> poses;
  for (const double angle : angles) {
    const double part = (std::numbers::pi - angle) / kTurn;
    poses.push_back(scanner_pose(scene.ego, (part - 0.5) * model.duration));
  }
  std::vector<LidarReturn> result;
  std::vector<std::pair<double, LidarReturn>> ring_returns;
  for (std::size_t ring = 0; ring < model.beams.size(); ++ring) {
    const LidarBeam& beam = model.beams[ring];
    ring_returns.clear();
    for (std::size_t firing = 0; firing < angles.size(); ++firing) {
      if (std::abs(angles[firing]) > model.half_field_of_view) continue;
      const Pulse pulse = pulse_of(beam, angles[firing]);
      const double part = (std::numbers::pi - angles[firing]) / kTurn;
      const Eigen::Vector3d direction = poses[firing].linear() * pulse.direction;
      const RandomStream random(scene.seed, ring << 16 | firing, kPulse);
      Echo echo;
      echo.hit.material = Material::kMetal;
      if (!options.ideal) echo.range = own_range(model, beam, pulse.azimuth, random);
      if (echo.range == 0.0 && (hidden(beam, pulse.azimuth) ||
                                !echo_of(tracer, model, beam, poses[firing] * pulse.origin,
                                         direction, part, random, options.ideal, echo))) {
        continue;
      }
      Eigen::Vector3d point = pulse.origin + echo.range * pulse.direction;
      double intensity = echo.intensity;
      if (options.motion_compensated) point = poses[firing] * point;
      if (!options.ideal) {
        for (double& value : point) value = rounded(value, model.coordinate_step);
        intensity = std::min(rounded(intensity, model.intensity_step), model.intensity_limit);
      }
      const double azimuth = std::atan2(point.y(), point.x());
      ring_returns.push_back({azimuth < 0.0 ? azimuth + kTurn : azimuth,
                              {.x = static_cast<float>(point.x()),
                               .y = static_cast<float>(point.y()),
                               .z = static_cast<float>(point.z()),
                               .intensity = static_cast<float>(intensity),
                               .ring = static_cast<std::uint16_t>(ring),
                               .firing = static_cast<std::uint16_t>(firing),
                               .time = static_cast<float>(part * model.duration),
                               .object = echo.hit.object,
                               .material = echo.hit.material}});
    }
    std::stable_sort(ring_returns.begin(), ring_returns.end(),
                     [](const auto& a, const auto& b) { return a.first < b.first; });
    for (const auto& [azimuth, value] : ring_returns) result.push_back(value);
  }
  return result;
}

geometry::PointCloud to_cloud(const std::vector<LidarReturn>& returns) {
  geometry::PointCloud cloud{.channels = {"intensity"}, .values = {}};
  cloud.values.reserve(4 * returns.size());
  for (const LidarReturn& point : returns) {
    cloud.values.insert(cloud.values.end(), {point.x, point.y, point.z, point.intensity});
  }
  return cloud;
}

}  // namespace arbox::simulation
