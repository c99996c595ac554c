#include "arbox/detectors/cluster_fit/internal/ground.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "arbox/base/parallel.h"
#include "arbox/base/random.h"

namespace arbox::detectors::internal {
namespace {

constexpr int kSectors = 180;
// Ring i covers radii kScale (exp(kGrowth i) - 1) to kScale (exp(kGrowth (i + 1)) - 1): 0.6 m deep
// at the sensor, 2.4 m at 60 m, as the rings of a spinning scanner spread.
constexpr double kGrowth = 0.03;
constexpr double kScale = 20.0;
// Ghost returns below the ground come alone: the lowest return counts once two are near it.
constexpr int kLowest = 3;
constexpr float kSameHeight = 0.3f;
constexpr double kNearRange = 25.0;
constexpr int kHypotheses = 200;
constexpr double kPlaneDepth = 0.12;
constexpr std::uint32_t kPlanePurpose = 0x47524f55;
constexpr double kReturnVariance = 0.05 * 0.05;
constexpr double kLateralSlope = 0.06;
// Metres over which a slope that no return confirms is forgotten.
constexpr double kSlopeMemory = 30.0;
constexpr std::int64_t kGrain = 4096;

/// Places in the polar grid: whole numbers are where rings and sectors begin.
struct Places {
  Eigen::ArrayXf ring, sector;
};

/// atan2 within 2e-6: Eigen has none for whole arrays.
Eigen::ArrayXf angle_of(const Eigen::ArrayXf& x, const Eigen::ArrayXf& y) {
  constexpr float kPi = std::numbers::pi_v<float>;
  const Eigen::ArrayXf wide = x.abs().max(y.abs()).max(std::numeric_limits<float>::min());
  const Eigen::ArrayXf ratio = x.abs().min(y.abs()) / wide;
  const Eigen::ArrayXf square = ratio.square();
  // Chebyshev fit of atan(sqrt(t)) / sqrt(t) over [0, 1].
  Eigen::ArrayXf angle = Eigen::ArrayXf::Constant(x.size(), 0.00764835f);
  for (const float coefficient :
       {-0.03636043f, 0.08312645f, -0.13447864f, 0.1987204f, -0.33325678f, 0.99999923f}) {
    angle = angle * square + coefficient;
  }
  angle *= ratio;
  angle = (y.abs() > x.abs()).select(0.5f * kPi - angle, angle);
  angle = (x < 0.0f).select(kPi - angle, angle);
  return (y < 0.0f).select(-angle, angle);
}

Places places_of(std::span<const Eigen::Vector3f> points) {
  const auto count = static_cast<Eigen::Index>(points.size());
  Eigen::ArrayXf x(count), y(count);
  for (Eigen::Index i = 0; i < count; ++i) {
    x[i] = points[i].x();
    y[i] = points[i].y();
  }
  const Eigen::ArrayXf radius = (x.square() + y.square()).sqrt();
  return {(1.0f + radius / static_cast<float>(kScale)).log() / static_cast<float>(kGrowth),
          (angle_of(x, y) / (2.0f * std::numbers::pi_v<float>)+0.5f) * kSectors};
}

}  // namespace

struct GroundSurface::Bin {
  std::array<Eigen::Vector3f, kLowest> lowest;
  int count = 0;

  void add(const Eigen::Vector3f& point) {
    int place = std::min(count, kLowest);
    while (place > 0 && lowest[place - 1].z() > point.z()) {
      if (place < kLowest) lowest[place] = lowest[place - 1];
      --place;
    }
    if (place < kLowest) lowest[place] = point;
    count = std::min(count + 1, kLowest);
  }

  const Eigen::Vector3f* ground_candidate() const {
    if (count == 0) return nullptr;
    for (int i = 0; i + 1 < count; ++i) {
      if (lowest[i + 1].z() - lowest[i].z() < kSameHeight) return &lowest[i];
    }
    return &lowest[count - 1];
  }
};

GroundSurface::GroundSurface(std::span<const Eigen::Vector3f> points, const GroundOptions& options,
                             double max_range, int threads)
    : options_(options) {
  rings_ = 1 + static_cast<int>(std::log1p(max_range / kScale) / kGrowth);
  for (int ring = 0; ring < rings_; ++ring) {
    radius_.push_back(static_cast<float>(kScale * std::expm1(kGrowth * (ring + 0.5))));
  }
  heights_.assign(static_cast<std::size_t>(rings_) * kSectors, 0.0f);
  const std::vector<Bin> bins = lowest_returns(points, threads);
  walk(bins, near_plane(bins));
}

std::vector<GroundSurface::Bin> GroundSurface::lowest_returns(
    std::span<const Eigen::Vector3f> points, int threads) const {
  const auto count = static_cast<std::int64_t>(points.size());
  std::vector<std::int32_t> bin_of(points.size());
  parallel_for(count, kGrain, threads, [&](std::int64_t begin, std::int64_t end) {
    const Places places = places_of(points.subspan(begin, end - begin));
    for (std::int64_t i = begin; i < end; ++i) {
      const int ring = std::clamp(static_cast<int>(places.ring[i - begin]), 0, rings_ - 1);
      const int sector = std::clamp(static_cast<int>(places.sector[i - begin]), 0, kSectors - 1);
      bin_of[i] = ring * kSectors + sector;
    }
  });
  std::vector<Bin> bins(heights_.size());
  for (std::int64_t i = 0; i < count; ++i) bins[bin_of[i]].add(points[i]);
  return bins;
}

GroundSurface::Plane GroundSurface::near_plane(const std::vector<Bin>& bins) const {
  std::vector<Eigen::Vector3d> lows;
  for (int ring = 0; ring < rings_ && (radius_[ring] < kNearRange || lows.size() < 3); ++ring) {
    for (int sector = 0; sector < kSectors; ++sector) {
      const auto* low = bins[ring * kSectors + sector].ground_candidate();
      if (low != nullptr) lows.push_back(low->cast<double>());
    }
  }
  if (lows.empty()) return {};
  Plane best{.c =
                 std::min_element(lows.begin(), lows.end(), [](const auto& one, const auto& other) {
                   return one.z() < other.z();
                 })->z()};
  const RandomStream stream(0, 0, kPlanePurpose);
  const auto count = static_cast<std::uint32_t>(lows.size());
  Eigen::ArrayXd x(count), y(count), z(count);
  for (std::uint32_t i = 0; i < count; ++i) {
    x[i] = lows[i].x();
    y[i] = lows[i].y();
    z[i] = lows[i].z();
  }
  const auto support = [&](const Plane& plane) {
    return ((plane.a * x + plane.b * y + plane.c - z).abs() < kPlaneDepth).count();
  };
  auto best_support = support(best);
  for (std::uint32_t trial = 0; trial < kHypotheses && count >= 3; ++trial) {
    const Eigen::Vector3d& p = lows[stream.below(3 * trial, count)];
    const Eigen::Vector3d q = lows[stream.below(3 * trial + 1, count)] - p;
    const Eigen::Vector3d r = lows[stream.below(3 * trial + 2, count)] - p;
    const Eigen::Vector3d normal = q.cross(r);
    if (std::abs(normal.z()) < 1e-3) continue;
    Plane plane{.a = -normal.x() / normal.z(), .b = -normal.y() / normal.z()};
    if (std::hypot(plane.a, plane.b) > options_.max_slope) continue;
    plane.c = p.z() - plane.a * p.x() - plane.b * p.y();
    const auto found = support(plane);
    if (found > best_support) {
      best = plane;
      best_support = found;
    }
  }
  return best;
}

void GroundSurface::walk(const std::vector<Bin>& bins, const Plane& plane) {
  struct Track {
    double height, slope;
    double usual_slope;  // to which the slope returns where no ground is seen
    double hh, hs, ss;   // covariance
  };
  std::vector<Track> tracks(kSectors);
  for (int sector = 0; sector < kSectors; ++sector) {
    const double angle = ((sector + 0.5) / kSectors - 0.5) * 2.0 * std::numbers::pi;
    const double slope = plane.a * std::cos(angle) + plane.b * std::sin(angle);
    tracks[sector] = {plane.c, slope, slope, 0.01, 0.0, 2.5e-3};
  }
  std::vector<char> measured(bins.size(), 0);
  double last_radius = 0.0;
  for (int ring = 0; ring < rings_; ++ring) {
    const double step = radius_[ring] - last_radius;
    last_radius = radius_[ring];
    const double kept = std::exp(-step / kSlopeMemory);
    for (Track& track : tracks) {
      track.slope = track.usual_slope + kept * (track.slope - track.usual_slope);
      track.height += step * track.slope;
      track.hh += step * (2.0 * track.hs + step * track.ss);
      track.hs += step * track.ss;
      track.ss += step * options_.slope_change * options_.slope_change;
    }
    const std::vector<Track> expected = tracks;
    const double lateral = kLateralSlope * radius_[ring] * 2.0 * std::numbers::pi / kSectors;
    for (int sector = 0; sector < kSectors; ++sector) {
      Track& track = tracks[sector];
      double weight = 1.0 / track.hh, sum = weight * track.height;
      for (int away : {-2, -1, 1, 2}) {
        const Track& other = expected[(sector + away + kSectors) % kSectors];
        const double share = 1.0 / (other.hh + away * away * lateral * lateral + 1e-3);
        weight += share;
        sum += share * other.height;
      }
      const double before = track.hh;
      track.height = sum / weight;
      track.hh = 1.0 / weight;
      track.hs *= std::sqrt(track.hh / before);

      const int bin = ring * kSectors + sector;
      const auto* low = bins[bin].ground_candidate();
      if (low != nullptr) {
        const double radius = std::hypot(low->x(), low->y());
        const double at_centre = low->z() + (radius_[ring] - radius) * track.slope;
        const double miss = at_centre - track.height;
        const double variance = track.hh + kReturnVariance;
        if (std::abs(miss) < std::min(3.0 * std::sqrt(variance), options_.max_step)) {
          const double gain_h = track.hh / variance, gain_s = track.hs / variance;
          track.height += gain_h * miss;
          track.slope += gain_s * miss;
          track.ss -= gain_s * track.hs;
          track.hs -= gain_s * track.hh;
          track.hh -= gain_h * track.hh;
          measured[bin] = 1;
        }
      }
      heights_[bin] = static_cast<float>(track.height);
    }
  }
  fill(measured);
}

void GroundSurface::fill(const std::vector<char>& measured) {
  for (int sector = 0; sector < kSectors; ++sector) {
    int last = -1;
    for (int ring = 0; ring < rings_; ++ring) {
      if (!measured[ring * kSectors + sector]) continue;
      for (int between = last + 1; last >= 0 && between < ring; ++between) {
        const float share = (radius_[between] - radius_[last]) / (radius_[ring] - radius_[last]);
        heights_[between * kSectors + sector] =
            (1.0f - share) * heights_[last * kSectors + sector] +
            share * heights_[ring * kSectors + sector];
      }
      last = ring;
    }
  }
}

float GroundSurface::between(float ring, float turn) const {
  ring = std::clamp(ring - 0.5f, 0.0f, static_cast<float>(rings_ - 1));
  turn -= 0.5f;
  const int low_ring = static_cast<int>(ring);
  const int high_ring = std::min(low_ring + 1, rings_ - 1);
  const int whole = turn < 0.0f ? -1 : static_cast<int>(turn);
  const int low_sector = whole < 0 ? kSectors - 1 : std::min(whole, kSectors - 1);
  const int high_sector = low_sector + 1 < kSectors ? low_sector + 1 : 0;
  const float across = turn - static_cast<float>(whole),
              along = ring - static_cast<float>(low_ring);
  const auto at = [&](int r, int s) { return heights_[r * kSectors + s]; };
  return (1.0f - along) *
             ((1.0f - across) * at(low_ring, low_sector) + across * at(low_ring, high_sector)) +
         along *
             ((1.0f - across) * at(high_ring, low_sector) + across * at(high_ring, high_sector));
}

float GroundSurface::height(float x, float y) const {
  const Eigen::Vector3f point(x, y, 0.0f);
  return heights({&point, 1})[0];
}

std::vector<float> GroundSurface::heights(std::span<const Eigen::Vector3f> points) const {
  const Places places = places_of(points);
  std::vector<float> result(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto place = static_cast<Eigen::Index>(i);
    result[i] = between(places.ring[place], places.sector[place]);
  }
  return result;
}

}  // namespace arbox::detectors::internal
