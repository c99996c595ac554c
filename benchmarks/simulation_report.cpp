// Compares simulated street scans with real ones: tables as Markdown on standard output, plots of
// aggregate figures as PNG.
//
//     simulation_report REAL SIMULATED FIGURES [REAL_LABELS]
//
// REAL and SIMULATED are folders in the KITTI object benchmark's layout, FIGURES is a folder for
// the plots, REAL_LABELS a folder of label files for the label statistics (default: REAL's).

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <map>
#include <numbers>
#include <set>
#include <vector>

#include "arbox/base/random.h"
#include "arbox/drawing/curves.h"
#include "arbox/evaluation/ranking.h"
#include "arbox/io/kitti.h"
#include "arbox/io/kitti_dataset.h"
#include "arbox/io/kitti_label.h"

namespace {

using namespace arbox;
using Histogram = std::vector<double>;

constexpr double kDistances[] = {5, 10, 15, 20, 30, 40, 50, 80};
constexpr int kDistanceCount = 7, kCountBins = 12, kResamples = 200;

struct ObjectFigures {
  std::string type;
  double distance = 0, points = 0;
  int occlusion = 0;
  double truncation = 0;
  Eigen::VectorXd features;
};

struct ScanFigures {
  double points = 0, in_image = 0;
  Histogram range = Histogram(80), ring = Histogram(64), intensity = Histogram(21),
            azimuth = Histogram(72);
  std::vector<ObjectFigures> objects;
};

std::vector<int> ring_numbers(const geometry::PointCloudView& cloud) {
  std::vector<int> rings;
  double before = -1.0;
  int ring = 0;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Eigen::Vector3f p = cloud.position(i);
    double azimuth = std::atan2(p.y(), p.x());
    if (azimuth < 0) azimuth += 2 * std::numbers::pi;
    if (azimuth < before - std::numbers::pi) ++ring;
    before = azimuth;
    rings.push_back(std::min(ring, 63));
  }
  return rings;
}

double quantile(std::vector<double> values, double q) {
  if (values.empty()) return std::nan("");
  const auto k = static_cast<std::size_t>(q * static_cast<double>(values.size() - 1) + 0.5);
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(k), values.end());
  return values[k];
}

ObjectFigures figures_of(const io::KittiObject& label, const geometry::Box& box,
                         const geometry::PointCloudView& cloud, const std::vector<int>& rings) {
  const geometry::Channel& channel = *cloud.find("intensity");
  std::vector<double> x, y, z;
  std::set<int> seen;
  double sum = 0, squares = 0, zeros = 0;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Eigen::Vector3d local =
        box.rotation.conjugate() * (cloud.position(i).cast<double>() - box.center);
    if ((local.cwiseAbs() - 0.5 * box.size).maxCoeff() > 0 || local.z() < 0.15 - 0.5 * box.size.z())
      continue;
    x.push_back(local.x());
    y.push_back(local.y());
    z.push_back(local.z());
    seen.insert(rings[i]);
    const double intensity = cloud.value(channel, i);
    sum += intensity;
    squares += intensity * intensity;
    zeros += intensity == 0;
  }
  ObjectFigures result{.type = label.type,
                       .distance = std::hypot(label.x, label.z),
                       .points = static_cast<double>(x.size()),
                       .occlusion = label.occlusion,
                       .truncation = label.truncation,
                       .features = {}};
  if (x.size() < 10) return result;
  const double n = result.points, mean = sum / n;
  const auto extent = [&](const std::vector<double>& v) {
    return quantile(v, 0.98) - quantile(v, 0.02);
  };
  const double span = *seen.rbegin() - *seen.begin() + 1;
  result.features.resize(9);
  result.features << std::log(n) + 2 * std::log(result.distance), extent(x) / box.size.x(),
      extent(y) / box.size.y(), extent(z) / box.size.z(), static_cast<double>(seen.size()) / span,
      n / static_cast<double>(seen.size()) * result.distance / 100, mean,
      std::sqrt(std::max(0.0, squares / n - mean * mean)), zeros / n;
  return result;
}

std::vector<ScanFigures> read_scans(const std::filesystem::path& root) {
  const io::KittiDataset dataset = io::KittiDataset::open(root);
  std::vector<ScanFigures> scans;
  for (const std::string& id : dataset.frames("training")) {
    const io::KittiFrame frame = dataset.load("training", id);
    const geometry::PointCloudView cloud = frame.cloud.view();
    const std::vector<int> rings = ring_numbers(cloud);
    const geometry::Channel& channel = *cloud.find("intensity");
    ScanFigures& scan = scans.emplace_back();
    scan.points = static_cast<double>(cloud.size());
    if (frame.image_size) {
      scan.in_image = static_cast<double>(
          io::points_in_image(cloud, frame.calibration, *frame.image_size).size());
    }
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      const Eigen::Vector3f p = cloud.position(i);
      const double intensity = cloud.value(channel, i);
      scan.range[std::min<std::size_t>(79, static_cast<std::size_t>(p.norm()))] += 1;
      scan.ring[static_cast<std::size_t>(rings[i])] += 1;
      scan.intensity[intensity < 0.005 ? 0 : 1 + static_cast<std::size_t>(intensity * 19.99)] += 1;
      const double turn = std::atan2(p.y(), p.x()) / std::numbers::pi;
      scan.azimuth[std::min<std::size_t>(71, static_cast<std::size_t>((turn + 1) * 36))] += 1;
    }
    for (const io::KittiObject& label : frame.labels) {
      if (!io::has_box(label)) continue;
      scan.objects.push_back(figures_of(label, io::to_box(label, frame.calibration), cloud, rings));
    }
  }
  return scans;
}

/// Points an object by distance: a histogram over both, every object weight 1.
Histogram points_by_distance(const ScanFigures& scan) {
  Histogram result(static_cast<std::size_t>(kDistanceCount * kCountBins));
  for (const ObjectFigures& object : scan.objects) {
    if (object.type != "Car" || object.occlusion > 1 || object.truncation > 0.1) continue;
    const auto at = std::upper_bound(std::begin(kDistances), std::end(kDistances), object.distance);
    const auto row = at - std::begin(kDistances) - 1;
    if (row < 0 || row >= kDistanceCount) continue;
    const int column =
        std::clamp(static_cast<int>(std::log2(object.points + 1)), 0, kCountBins - 1);
    result[static_cast<std::size_t>(row * kCountBins + column)] += 1;
  }
  return result;
}

using Select = Histogram (*)(const ScanFigures&);

Histogram total(const std::vector<const ScanFigures*>& scans, Select select) {
  Histogram sum;
  for (const ScanFigures* scan : scans) {
    const Histogram one = select(*scan);
    sum.resize(one.size());
    for (std::size_t i = 0; i < one.size(); ++i) sum[i] += one[i];
  }
  return sum;
}

Histogram normalised(Histogram values) {
  double sum = 0;
  for (const double value : values) sum += value;
  for (double& value : values) value /= std::max(sum, 1e-12);
  return values;
}

/// Base 2: 0 for equal, 1 for disjoint distributions.
double jensen_shannon(const Histogram& a, const Histogram& b) {
  const Histogram p = normalised(a), q = normalised(b);
  double sum = 0;
  for (std::size_t i = 0; i < p.size(); ++i) {
    const double middle = 0.5 * (p[i] + q[i]);
    if (p[i] > 0) sum += 0.5 * p[i] * std::log2(p[i] / middle);
    if (q[i] > 0) sum += 0.5 * q[i] * std::log2(q[i] / middle);
  }
  return sum;
}

std::vector<const ScanFigures*> all_of(const std::vector<ScanFigures>& scans) {
  std::vector<const ScanFigures*> result;
  for (const ScanFigures& scan : scans) result.push_back(&scan);
  return result;
}

/// Two random halves of the scans.
std::pair<std::vector<const ScanFigures*>, std::vector<const ScanFigures*>> halves(
    const std::vector<ScanFigures>& scans, std::uint64_t draw) {
  std::vector<std::pair<double, const ScanFigures*>> order;
  const RandomStream random(1, draw, 1);
  for (std::size_t i = 0; i < scans.size(); ++i) {
    order.emplace_back(random.uniform(static_cast<std::uint32_t>(i)), &scans[i]);
  }
  std::sort(order.begin(), order.end());
  std::pair<std::vector<const ScanFigures*>, std::vector<const ScanFigures*>> result;
  for (std::size_t i = 0; i < order.size(); ++i) {
    (i % 2 == 0 ? result.first : result.second).push_back(order[i].second);
  }
  return result;
}

void print_divergence(const char* name, Select select, const std::vector<ScanFigures>& real,
                      const std::vector<ScanFigures>& simulated) {
  const double apart =
      jensen_shannon(total(all_of(real), select), total(all_of(simulated), select));
  std::vector<double> band;
  for (int i = 0; i < kResamples; ++i) {
    const auto [a, b] = halves(real, static_cast<std::uint64_t>(i));
    band.push_back(jensen_shannon(total(a, select), total(b, select)));
  }
  std::printf("| %s | %.4f | %.4f .. %.4f |\n", name, apart, quantile(band, 0.05),
              quantile(band, 0.95));
}

struct Sample {
  double distance;
  Eigen::VectorXd features;
};

std::vector<Sample> cars(const std::vector<const ScanFigures*>& scans) {
  std::vector<Sample> result;
  for (const ScanFigures* scan : scans) {
    for (const ObjectFigures& object : scan->objects) {
      if (object.type == "Car" && object.truncation < 0.1 && object.features.size() > 0) {
        result.push_back({object.distance, object.features});
      }
    }
  }
  return result;
}

/// For each of `wanted` the `count` unused samples whose distance is nearest.
std::vector<Sample> matched(const std::vector<Sample>& wanted, std::vector<Sample> from,
                            int count) {
  std::vector<Sample> result;
  for (int round = 0; round < count; ++round) {
    for (const Sample& one : wanted) {
      if (from.empty()) return result;
      const auto best =
          std::min_element(from.begin(), from.end(), [&](const auto& a, const auto& b) {
            return std::abs(a.distance - one.distance) < std::abs(b.distance - one.distance);
          });
      result.push_back(*best);
      from.erase(best);
    }
  }
  return result;
}

/// Ridge logistic regression on standardised features and their squares; classes weigh the same.
Eigen::VectorXd fit_logistic(const Eigen::MatrixXd& rows, const Eigen::VectorXd& labels) {
  const double positives = labels.sum(), n = static_cast<double>(labels.size());
  Eigen::VectorXd weights = Eigen::VectorXd::Zero(rows.cols());
  for (int step = 0; step < 25; ++step) {
    Eigen::MatrixXd hessian = Eigen::MatrixXd::Identity(rows.cols(), rows.cols());
    Eigen::VectorXd gradient = weights;
    for (Eigen::Index i = 0; i < rows.rows(); ++i) {
      const double p = 1 / (1 + std::exp(-rows.row(i).dot(weights)));
      const double share = 0.5 * n / (labels[i] > 0.5 ? positives : n - positives);
      gradient += share * (p - labels[i]) * rows.row(i).transpose();
      hessian += share * p * (1 - p) * rows.row(i).transpose() * rows.row(i);
    }
    weights -= hessian.ldlt().solve(gradient);
  }
  return weights;
}

/// Area under the ROC curve of a classifier of the two sets, five-fold cross-validated.
double classifier_auc(const std::vector<Sample>& first, const std::vector<Sample>& second) {
  const auto count = static_cast<Eigen::Index>(first.size() + second.size());
  if (first.size() < 10 || second.size() < 10) return std::nan("");
  const Eigen::Index width = first[0].features.size();
  Eigen::MatrixXd rows(count, 2 * width + 1);
  Eigen::VectorXd labels(count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const auto k = static_cast<std::size_t>(i);
    const bool is_first = k < first.size();
    rows.row(i).head(width) = (is_first ? first[k] : second[k - first.size()]).features;
    labels[i] = is_first;
  }
  for (Eigen::Index j = 0; j < width; ++j) {
    rows.col(j).array() -= rows.col(j).mean();
    rows.col(j) /= std::sqrt(rows.col(j).squaredNorm() / static_cast<double>(count)) + 1e-9;
    rows.col(j) = rows.col(j).cwiseMin(3.0).cwiseMax(-3.0).eval();
    rows.col(width + j) = 0.5 * rows.col(j).cwiseAbs2();
  }
  rows.col(2 * width).setOnes();
  std::vector<double> scores(static_cast<std::size_t>(count));
  std::vector<bool> positive;
  for (Eigen::Index i = 0; i < count; ++i) positive.push_back(labels[i] > 0.5);
  for (int fold = 0; fold < 5; ++fold) {
    std::vector<Eigen::Index> train, test;
    for (Eigen::Index i = 0; i < count; ++i) (i % 5 == fold ? test : train).push_back(i);
    const Eigen::VectorXd weights = fit_logistic(rows(train, Eigen::all), labels(train));
    for (const Eigen::Index i : test) scores[static_cast<std::size_t>(i)] = rows.row(i) * weights;
  }
  return evaluation::roc_auc(scores, positive).value_or(std::nan(""));
}

void print_classifier(const std::vector<ScanFigures>& real,
                      const std::vector<ScanFigures>& simulated) {
  const std::vector<Sample> wanted = cars(all_of(real));
  const std::vector<Sample> others = matched(wanted, cars(all_of(simulated)), 3);
  std::vector<double> band;
  for (int i = 0; i < 50; ++i) {
    const auto [a, b] = halves(real, static_cast<std::uint64_t>(1000 + i));
    const double auc = classifier_auc(cars(a), cars(b));
    if (std::isfinite(auc)) band.push_back(auc);
  }
  std::printf(
      "| classifier AUC, %zu real and %zu simulated cars at matched range | %.3f | "
      "%.3f .. %.3f |\n",
      wanted.size(), others.size(), classifier_auc(wanted, others), quantile(band, 0.05),
      quantile(band, 0.95));
  const char* names[] = {"log n d^2",      "length covered", "width covered",
                         "height covered", "rings hit",      "points a ring",
                         "mean intensity", "intensity sd",   "zero intensity"};
  std::printf("\n| feature of cars | real 10/50/90 %% | simulated 10/50/90 %% |\n|---|---|---|\n");
  for (Eigen::Index j = 0; j < 9; ++j) {
    std::printf("| %s |", names[j]);
    for (const std::vector<Sample>* set : {&wanted, &others}) {
      std::vector<double> values;
      for (const Sample& sample : *set) values.push_back(sample.features[j]);
      std::printf(" %.2f / %.2f / %.2f |", quantile(values, .1), quantile(values, .5),
                  quantile(values, .9));
    }
    std::printf("\n");
  }
}

void print_counts(const std::vector<ScanFigures>& real, const std::vector<ScanFigures>& simulated) {
  std::printf("\n| quantity | real 10/50/90 %% | simulated 10/50/90 %% |\n|---|---|---|\n");
  for (const auto& [name, member] : {std::pair{"points a scan", &ScanFigures::points},
                                     std::pair{"points in the image", &ScanFigures::in_image}}) {
    std::printf("| %s |", name);
    for (const auto* scans : {&real, &simulated}) {
      std::vector<double> values;
      for (const ScanFigures& scan : *scans) values.push_back(scan.*member);
      std::printf(" %.0f / %.0f / %.0f |", quantile(values, .1), quantile(values, .5),
                  quantile(values, .9));
    }
    std::printf("\n");
  }
  for (const char* type : {"Car", "Pedestrian", "Cyclist"}) {
    for (int row = 0; row < kDistanceCount; ++row) {
      std::printf("| points, %s, %.0f-%.0f m, occlusion 0 |", type, kDistances[row],
                  kDistances[row + 1]);
      for (const auto* scans : {&real, &simulated}) {
        std::vector<double> values;
        for (const ScanFigures& scan : *scans) {
          for (const ObjectFigures& object : scan.objects) {
            if (object.type == type && object.occlusion == 0 && object.truncation < .1 &&
                object.distance >= kDistances[row] && object.distance < kDistances[row + 1]) {
              values.push_back(object.points);
            }
          }
        }
        if (values.empty()) {
          std::printf(" - |");
        } else {
          std::printf(" %.0f / %.0f / %.0f (n=%zu) |", quantile(values, .1), quantile(values, .5),
                      quantile(values, .9), values.size());
        }
      }
      std::printf("\n");
    }
  }
}

struct LabelFigures {
  std::map<std::string, std::vector<io::KittiObject>> objects;
  double frames = 0;
};

LabelFigures read_labels(const std::filesystem::path& folder) {
  LabelFigures figures;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    figures.frames += 1;
    for (const io::KittiObject& label : io::read_kitti_labels(entry.path())) {
      figures.objects[label.type].push_back(label);
    }
  }
  return figures;
}

void print_labels(const LabelFigures& real, const LabelFigures& simulated) {
  std::printf(
      "\n| class | | a frame | distance 5/50/95 %% | occlusion 0/1/2/3 | truncated | "
      "same / opposite heading | left |\n|---|---|---|---|---|---|---|---|\n");
  for (const char* type : {"Car", "Van", "Truck", "Pedestrian", "Person_sitting", "Cyclist", "Tram",
                           "Misc", "DontCare"}) {
    for (const auto& [name, figures] : {std::pair{"real", &real}, {"simulated", &simulated}}) {
      const auto found = figures->objects.find(type);
      if (found == figures->objects.end()) continue;
      const auto& objects = found->second;
      const double n = static_cast<double>(objects.size());
      std::printf("| %s | %s | %.3f |", type, name, n / figures->frames);
      if (!io::has_box(objects[0])) {
        std::printf(" | | | | |\n");
        continue;
      }
      std::vector<double> distance;
      double level[4] = {}, truncated = 0, same = 0, opposite = 0, left = 0;
      for (const io::KittiObject& object : objects) {
        distance.push_back(std::hypot(object.x, object.z));
        ++level[std::clamp(object.occlusion, 0, 3)];
        truncated += object.truncation > 0;
        const double heading = geometry::wrap_angle(-object.rotation_y - 0.5 * std::numbers::pi);
        same += std::abs(heading) < 0.35;
        opposite += std::abs(heading) > std::numbers::pi - 0.35;
        left += object.x < 0;
      }
      std::printf(" %.1f / %.1f / %.1f | %.2f / %.2f / %.2f / %.2f | %.2f | %.2f / %.2f | %.2f |\n",
                  quantile(distance, .05), quantile(distance, .5), quantile(distance, .95),
                  level[0] / n, level[1] / n, level[2] / n, level[3] / n, truncated / n, same / n,
                  opposite / n, left / n);
    }
  }
}

drawing::Panel panel_of(const std::string& title, const std::string& axis, Select select,
                        double step, const std::vector<ScanFigures>& real,
                        const std::vector<ScanFigures>& simulated, bool logarithmic) {
  drawing::Panel panel;
  panel.title = title;
  panel.x.label = axis;
  panel.y.label = "share";
  panel.y.logarithmic = logarithmic;
  for (const auto& [name, scans] : {std::pair{"real", &real}, {"simulated", &simulated}}) {
    const Histogram heights = normalised(total(all_of(*scans), select));
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

}  // namespace

int main(int argc, char** argv) {
  if (argc < 4) {
    std::fprintf(stderr, "usage: simulation_report REAL SIMULATED FIGURES [REAL_LABELS]\n");
    return 2;
  }
  const std::filesystem::path real_root = argv[1], simulated_root = argv[2], figures = argv[3];
  const std::vector<ScanFigures> real = read_scans(real_root),
                                 simulated = read_scans(simulated_root);
  const Select range = [](const ScanFigures& scan) { return scan.range; };
  const Select ring = [](const ScanFigures& scan) { return scan.ring; };
  const Select intensity = [](const ScanFigures& scan) { return scan.intensity; };
  const Select azimuth = [](const ScanFigures& scan) { return scan.azimuth; };
  std::printf("%zu real and %zu simulated scans\n\n", real.size(), simulated.size());
  std::printf(
      "| Jensen-Shannon divergence | real against simulated | halves of the real scans, "
      "5..95 %% |\n|---|---|---|\n");
  print_divergence("range, 1 m bins", range, real, simulated);
  print_divergence("ring", ring, real, simulated);
  print_divergence("intensity, 0 and 20 bins", intensity, real, simulated);
  print_divergence("azimuth, 5 degrees", azimuth, real, simulated);
  print_divergence("points a car by distance", &points_by_distance, real, simulated);
  print_classifier(real, simulated);
  print_counts(real, simulated);
  print_labels(read_labels(argc > 4 ? argv[4] : real_root / "training" / "label_2"),
               read_labels(simulated_root / "training" / "label_2"));
  std::filesystem::create_directories(figures);
  const std::vector<drawing::Panel> panels = {
      panel_of("Range", "range, m", range, 1, real, simulated, true),
      panel_of("Ring", "ring from the top", ring, 1, real, simulated, false),
      panel_of("Intensity", "intensity", intensity, 0.05, real, simulated, false),
      panel_of("Azimuth", "azimuth + 180, degrees", azimuth, 5, real, simulated, false)};
  drawing::write_image(
      drawing::draw_figure(panels, {.title = "Real and simulated street scans", .columns = 2}),
      figures / "simulation_scans.png");
  return 0;
}
