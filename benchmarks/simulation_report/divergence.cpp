#include "divergence.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <iterator>

#include "arbox/base/random.h"

namespace arbox::benchmarks {
namespace {

constexpr int kResamples = 200;

/// Base 2: 0 for equal, 1 for disjoint distributions.
double jensen_shannon(const Histogram& p, const Histogram& q) {
  double sum = 0;
  for (std::size_t i = 0; i < p.size(); ++i) {
    const double middle = 0.5 * (p[i] + q[i]);
    if (p[i] > 0) sum += 0.5 * p[i] * std::log2(p[i] / middle);
    if (q[i] > 0) sum += 0.5 * q[i] * std::log2(q[i] / middle);
  }
  return sum;
}

using Order = std::vector<std::pair<double, const ScanFigures*>>;

Order shuffled(const std::vector<ScanFigures>& scans, std::uint64_t draw) {
  Order order;
  const RandomStream random(1, draw, 1);
  for (std::size_t i = 0; i < scans.size(); ++i) {
    order.emplace_back(random.uniform(static_cast<std::uint32_t>(i)), &scans[i]);
  }
  std::sort(order.begin(), order.end());
  return order;
}

/// `count` random scans and the others.
std::pair<Scans, Scans> split(const std::vector<ScanFigures>& scans, std::size_t count,
                              std::uint64_t draw) {
  std::pair<Scans, Scans> result;
  for (const auto& [key, scan] : shuffled(scans, draw)) {
    (result.first.size() < count ? result.first : result.second).push_back(scan);
  }
  return result;
}

/// How far apart two sets of scans are.
using Divergence = std::function<double(const Scans&, const Scans&)>;

Divergence of_shares(Select select) {
  return [select](const Scans& some, const Scans& others) {
    return jensen_shannon(shares(some, select), shares(others, select));
  };
}

/// Sums of points and numbers of objects by distance; mean points where there are objects.
struct PointsByDistance {
  static constexpr double kEdges[] = {5, 10, 15, 20, 25, 30, 40, 50, 80};
  static constexpr std::size_t kBins = std::size(kEdges) - 1;

  PointsByDistance(const Scans& scans, const char* type) {
    for (const ScanFigures* scan : scans) {
      for (const ObjectFigures& object : scan->objects) {
        if (object.type != type || object.occlusion > 1 || object.truncation > 0.1) continue;
        const auto edge = std::upper_bound(std::begin(kEdges), std::end(kEdges), object.distance);
        if (edge == std::begin(kEdges) || edge == std::end(kEdges)) continue;
        const auto bin = static_cast<std::size_t>(edge - std::begin(kEdges) - 1);
        points[bin] += object.points;
        objects[bin] += 1;
      }
    }
  }

  Histogram points = Histogram(kBins), objects = Histogram(kBins);
};

/// Of the mean points of an object by distance, as shares of their sum, over the distances that
/// both have.
Divergence of_mean_points(const char* type) {
  return [type](const Scans& some, const Scans& others) {
    const PointsByDistance first(some, type), second(others, type);
    Histogram p(PointsByDistance::kBins), q(PointsByDistance::kBins);
    double sum_p = 0, sum_q = 0;
    for (std::size_t i = 0; i < p.size(); ++i) {
      if (first.objects[i] == 0 || second.objects[i] == 0) continue;
      sum_p += p[i] = first.points[i] / first.objects[i];
      sum_q += q[i] = second.points[i] / second.objects[i];
    }
    for (double& value : p) value /= std::max(sum_p, 1e-12);
    for (double& value : q) value /= std::max(sum_q, 1e-12);
    return jensen_shannon(p, q);
  };
}

void print_band(const std::vector<ScanFigures>& scans, std::size_t count,
                const Divergence& divergence) {
  std::vector<double> band;
  for (std::uint64_t draw = 0; draw < kResamples; ++draw) {
    const auto [some, others] = split(scans, count, draw);
    band.push_back(divergence(some, others));
  }
  std::printf(" %.4f .. %.4f |", quantile(band, .05), quantile(band, .95));
}

void print_divergence(const char* name, const Divergence& divergence,
                      const std::vector<ScanFigures>& real,
                      const std::vector<ScanFigures>& simulated) {
  std::printf("| %s | %.4f |", name, divergence(all_of(real), all_of(simulated)));
  print_band(real, real.size() / 2, divergence);
  print_band(simulated, real.size(), divergence);
  std::printf("\n");
}

}  // namespace

Scans all_of(const std::vector<ScanFigures>& scans) {
  Scans result;
  for (const ScanFigures& scan : scans) result.push_back(&scan);
  return result;
}

std::pair<Scans, Scans> halves(const std::vector<ScanFigures>& scans, std::uint64_t draw) {
  return split(scans, scans.size() / 2, draw);
}

Histogram shares(const Scans& scans, Select select) {
  Histogram sum;
  for (const ScanFigures* scan : scans) {
    const Histogram one = select(*scan);
    sum.resize(one.size());
    for (std::size_t i = 0; i < one.size(); ++i) sum[i] += one[i];
  }
  double all = 0;
  for (const double value : sum) all += value;
  for (double& value : sum) value /= std::max(all, 1e-12);
  return sum;
}

Histogram points_by_distance(const ScanFigures& scan) {
  constexpr double kBands[] = {15, 30, 80}, kReturns[] = {10.9, 11.3, 11.6};
  Histogram result(12);
  for (const ObjectFigures& object : scan.objects) {
    if (object.type != "Car" || object.occlusion > 1 || object.truncation > 0.1) continue;
    const auto band = std::upper_bound(std::begin(kBands), std::end(kBands), object.distance);
    if (band == std::end(kBands)) continue;
    const double returns = std::log(object.points + 1) + 2 * std::log(object.distance);
    const auto bin = std::upper_bound(std::begin(kReturns), std::end(kReturns), returns);
    result[static_cast<std::size_t>((band - kBands) * 4 + (bin - kReturns))] += 1;
  }
  return result;
}

void print_divergences(const std::vector<ScanFigures>& real,
                       const std::vector<ScanFigures>& simulated) {
  std::printf(
      "| Jensen-Shannon divergence | real against simulated | halves of the real scans, 5..95 %% "
      "| %zu simulated scans against the others, 5..95 %% |\n|---|---|---|---|\n",
      real.size());
  const Select range = [](const ScanFigures& scan) { return scan.range; };
  const Select ring = [](const ScanFigures& scan) { return scan.ring; };
  const Select intensity = [](const ScanFigures& scan) { return scan.intensity; };
  const Select azimuth = [](const ScanFigures& scan) { return scan.azimuth; };
  print_divergence("range, 1 m bins", of_shares(range), real, simulated);
  print_divergence("ring", of_shares(ring), real, simulated);
  print_divergence("intensity, 0 and 20 bins", of_shares(intensity), real, simulated);
  print_divergence("azimuth, 5 degrees", of_shares(azimuth), real, simulated);
  print_divergence("mean points of a car by distance, 8 bins", of_mean_points("Car"), real,
                   simulated);
  print_divergence("mean points of a pedestrian by distance, 8 bins", of_mean_points("Pedestrian"),
                   real, simulated);
  print_divergence("points of single cars by distance, 12 bins", of_shares(&points_by_distance),
                   real, simulated);
}

}  // namespace arbox::benchmarks
