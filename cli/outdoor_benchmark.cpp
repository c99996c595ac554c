#include "arbox/cli/outdoor_benchmark.h"

#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <memory>

#include "arbox/base/parallel.h"
#include "arbox/cli/command_line.h"
#include "arbox/cli/detector_flags.h"
#include "arbox/cli/labelled_scans.h"
#include "arbox/cli/progress.h"
#include "arbox/cli/torch_module.h"
#include "arbox/io/kitti.h"
#include "arbox/io/kitti_dataset.h"
#include "arbox/io/model_search.h"

namespace arbox::cli {
namespace {

using evaluation::KittiFrame;
using evaluation::UncertaintyScan;
using geometry::Detection;

/// A detector of one head and one box, and what it is asked for.
struct Contestant {
  std::string name, box;
  std::unique_ptr<detectors::Detector> detector;
  detectors::DetectionRequest request;
};

/// The frames of one row as they are filled.
struct RowFrames {
  std::string detector, box;
  std::vector<KittiFrame> frames;
};

struct FoundScans {
  std::string name;
  std::vector<UncertaintyScan> scans;
};

std::string quantile_name(double q) { return "q " + std::to_string(q).substr(0, 4); }

detectors::DetectionRequest plain_request(const OutdoorBenchmarkOptions& options) {
  return {.score = options.score, .uncertainty = false};
}

Contestant model_contestant(const OutdoorBenchmarkOptions& options, const std::string& name,
                            const std::string& head, const std::string& box,
                            const detectors::DetectionRequest& request) {
  DetectorFlags flags;
  flags.model = options.model;
  flags.head = head;
  flags.mode = box;
  return {.name = name, .box = box, .detector = make_detector(flags), .request = request};
}

Contestant quantile_contestant(const OutdoorBenchmarkOptions& options, const std::string& head,
                               double q) {
  DetectorFlags flags;
  flags.model = options.model;
  flags.head = head;
  flags.mode = "quantile";
  flags.overrides = {"post.quantile=" + std::to_string(q)};
  return {.name = head,
          .box = quantile_name(q),
          .detector = make_detector(flags),
          .request = plain_request(options)};
}

Contestant cluster_fit_contestant(const detectors::DetectionRequest& request) {
  DetectorFlags flags;
  flags.detector = "cluster_fit";
  return {
      .name = "cluster_fit", .box = "box", .detector = make_detector(flags), .request = request};
}

std::vector<std::string> heads_of(const OutdoorBenchmarkOptions& options) {
  if (options.model.empty()) return {};
  if (!options.heads.empty()) return options.heads;
  return torch_module().model_heads(io::find_model(options.model).string());
}

/// The pointwise branch; heads with their own box and their mean; the classical baseline. Quantile
/// boxes come with the heads' own, `alone` from detectors that are asked for nothing else.
std::vector<Contestant> contestants(const OutdoorBenchmarkOptions& options, bool alone) {
  const detectors::DetectionRequest plain = plain_request(options);
  detectors::DetectionRequest sampled = plain;
  if (!alone) {
    sampled.quantiles = options.quantiles;
    sampled.samples = sampled.uncertainty = true;
  }
  std::vector<Contestant> result;
  const auto heads = heads_of(options);
  if (!heads.empty()) {
    result.push_back(model_contestant(options, "pointwise", heads[0], "pointwise", plain));
  }
  for (const std::string& head : heads) {
    if (head == "pointwise") continue;
    detectors::DetectionRequest request = sampled;
    if (!alone && head == heads[0]) request.confidences = options.confidences;
    result.push_back(model_contestant(options, head, head, "beam", request));
    result.push_back(model_contestant(options, head, head, "mean", plain));
    if (!alone) continue;
    for (const double q : options.quantiles) {
      result.push_back(quantile_contestant(options, head, q));
    }
  }
  if (options.cluster_fit) result.push_back(cluster_fit_contestant(sampled));
  if (result.empty()) throw UsageError("benchmark: expected a model or cluster_fit, got neither");
  return result;
}

/// What quantile boxes promise.
std::vector<double> promised(const std::vector<double>& quantiles) {
  std::vector<double> ps;
  for (const double q : quantiles) ps.push_back(1.0 - q);
  return ps;
}

/// Detections with a quantile box in the place of each one's own.
std::vector<Detection> with_quantile_box(std::vector<Detection> detections, double q) {
  for (Detection& detection : detections) {
    for (const auto& box : detection.quantile_boxes) {
      if (box.q == q) detection.box = box.box;
    }
  }
  return detections;
}

class Results {
 public:
  explicit Results(const OutdoorBenchmarkOptions& options) : options_(options) {}

  void add(const Contestant& contestant, const io::KittiFrame& frame,
           const std::vector<Detection>& objects, std::vector<Detection> found) {
    add_boxes(contestant.name, contestant.box, frame, found);
    if (contestant.request.quantiles.empty()) return;
    for (const double q : options_.quantiles) {
      add_boxes(contestant.name, quantile_name(q), frame, with_quantile_box(found, q));
    }
    if (contestant.name == "gaussian") {
      auto deviating = found;
      evaluation::use_gaussian_uncertainty(deviating);
      add_uncertainty("gaussian, G", objects, std::move(deviating));
    }
    add_uncertainty(contestant.name, objects, std::move(found));
  }

  std::vector<BenchmarkRow> rows() const {
    std::vector<BenchmarkRow> rows;
    for (const RowFrames& row : rows_) {
      rows.push_back(
          {.detector = row.detector,
           .box = row.box,
           .iou = evaluation::evaluate_kitti(row.frames),
           .iog = evaluation::evaluate_kitti(row.frames, {.overlap = geometry::Overlap::kIog}),
           .recall = evaluation::evaluate_recall(row.frames),
           .median_milliseconds = {},
           .slow_milliseconds = {}});
    }
    return rows;
  }

  std::vector<NamedUncertainty> uncertainty() const {
    std::vector<NamedUncertainty> result;
    for (const FoundScans& one : found_) {
      result.push_back({.name = one.name,
                        .report = evaluation::evaluate_uncertainty(
                            one.scans, {.classes = {"Car", "Pedestrian", "Cyclist"},
                                        .min_score = options_.found_score,
                                        .sample_confidences = promised(options_.quantiles)})});
    }
    return result;
  }

 private:
  void add_boxes(const std::string& detector, const std::string& box, const io::KittiFrame& frame,
                 const std::vector<Detection>& found) {
    auto row = std::find_if(rows_.begin(), rows_.end(), [&](const RowFrames& one) {
      return one.detector == detector && one.box == box;
    });
    if (row == rows_.end()) row = rows_.insert(rows_.end(), {detector, box, {}});
    row->frames.push_back(
        {.labels = frame.labels,
         .predictions = io::to_kitti_results(found, frame.calibration,
                                             frame.image_size.value_or(io::kUsualImageSize))});
  }

  void add_uncertainty(const std::string& name, const std::vector<Detection>& objects,
                       std::vector<Detection> found) {
    auto place = std::find_if(found_.begin(), found_.end(),
                              [&](const FoundScans& one) { return one.name == name; });
    if (place == found_.end()) place = found_.insert(found_.end(), {name, {}});
    std::erase_if(found, [&](const Detection& one) { return one.score < options_.found_score; });
    place->scans.push_back({.detections = std::move(found), .objects = objects});
  }

  const OutdoorBenchmarkOptions& options_;
  std::vector<RowFrames> rows_;
  std::vector<FoundScans> found_;
};

double milliseconds_of(const Contestant& contestant, const geometry::PointCloud& cloud) {
  const auto start = std::chrono::steady_clock::now();
  contestant.detector->detect(cloud.view(), contestant.request);
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start)
      .count();
}

void add_times(OutdoorBenchmark& benchmark, const std::vector<geometry::PointCloud>& clouds) {
  if (clouds.empty()) return;
  const auto all = contestants(benchmark.options, true);
  Progress progress("time", static_cast<std::int64_t>(all.size() * clouds.size()));
  for (const Contestant& contestant : all) {
    milliseconds_of(contestant, clouds.front());
    std::vector<double> times;
    for (const geometry::PointCloud& cloud : clouds) {
      times.push_back(milliseconds_of(contestant, cloud));
      progress.advance();
    }
    std::sort(times.begin(), times.end());
    for (BenchmarkRow& row : benchmark.rows) {
      if (row.detector != contestant.name || row.box != contestant.box) continue;
      row.median_milliseconds = times[times.size() / 2];
      row.slow_milliseconds = times[(times.size() - 1) * 95 / 100];
    }
  }
}

double peak_memory() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024.0;
}

}  // namespace

OutdoorBenchmark run_outdoor_benchmark(const OutdoorBenchmarkOptions& options) {
  const io::KittiDataset dataset = io::KittiDataset::open(options.data);
  std::vector<std::string> frames = dataset.frames(options.split);
  if (options.scans > 0 && std::ssize(frames) > options.scans) frames.resize(options.scans);
  const auto all = contestants(options, false);
  Results results(options);
  std::vector<geometry::PointCloud> timed;
  Progress progress("benchmark", static_cast<std::int64_t>(frames.size() * all.size()));
  for (const std::string& name : frames) {
    io::KittiFrame frame = dataset.load(options.split, name);
    const auto objects = labelled_objects(dataset.paths(options.split, name), options.all_round);
    for (const Contestant& one : all) {
      auto found = one.detector->detect(frame.cloud.view(), one.request).detections;
      results.add(one, frame, objects, std::move(found));
      progress.advance();
    }
    if (std::ssize(timed) < options.timed) timed.push_back(std::move(frame.cloud));
  }
  OutdoorBenchmark benchmark{.options = options,
                             .title = options.data.filename().string() + ", split " +
                                      options.split + ", " + std::to_string(frames.size()) +
                                      " scans",
                             .scans = frames.size(),
                             .rows = results.rows(),
                             .uncertainty = results.uncertainty(),
                             .threads = default_threads()};
  add_times(benchmark, timed);
  benchmark.peak_memory = peak_memory();
  return benchmark;
}

}  // namespace arbox::cli
