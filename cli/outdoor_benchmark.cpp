#include "arbox/cli/outdoor_benchmark.h"

#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <span>

#include "arbox/base/parallel.h"
#include "arbox/cli/benchmark_contestants.h"
#include "arbox/cli/labelled_scans.h"
#include "arbox/cli/progress.h"
#include "arbox/io/kitti.h"
#include "arbox/io/kitti_dataset.h"

namespace arbox::cli {
namespace {

using evaluation::KittiFrame;
using evaluation::UncertaintyScan;
using geometry::Detection;

/// The frames of one row as they are filled.
struct RowFrames {
  std::string detector, box;
  std::vector<KittiFrame> frames;
};

struct FoundScans {
  std::string name;
  std::vector<UncertaintyScan> scans;
};

/// What quantile boxes promise.
std::vector<double> promised(const std::vector<double>& quantiles) {
  std::vector<double> ps;
  ps.reserve(quantiles.size());
  for (const double q : quantiles) ps.push_back(1.0 - q);
  return ps;
}

/// The labels that average precision and recall are told of. Boxes that the camera does not show
/// may still reach into its view: what finds them is neither right nor wrong there.
std::vector<io::KittiObject> with_ignored(std::vector<io::KittiObject> labels,
                                          std::vector<io::KittiObject> unseen) {
  for (io::KittiObject& label : unseen) {
    label.truncation = 1.0;
    label.occlusion = 3;
    labels.push_back(std::move(label));
  }
  return labels;
}

std::vector<io::KittiObject> result_lines(std::span<const Detection> detections,
                                          const io::KittiFrame& frame) {
  return io::to_kitti_results(detections, frame.calibration,
                              frame.image_size.value_or(io::kUsualImageSize));
}

/// `line` with place, sizes and rotation of `box`.
io::KittiObject in_space(io::KittiObject line, const io::KittiObject& box) {
  line.height = box.height;
  line.width = box.width;
  line.length = box.length;
  line.x = box.x;
  line.y = box.y;
  line.z = box.z;
  line.rotation_y = box.rotation_y;
  return line;
}

/// Quantile boxes in space with the 2-D boxes of the detections' own: the protocol leaves out what
/// is small in the image, and no object shall enter or leave with q.
std::vector<io::KittiObject> quantile_lines(const std::vector<Detection>& detections, double q,
                                            const io::KittiFrame& frame) {
  std::vector<io::KittiObject> lines;
  for (const Detection& detection : detections) {
    for (io::KittiObject& line : result_lines({&detection, 1}, frame)) {
      for (const auto& box : detection.quantile_boxes) {
        if (box.q == q) line = in_space(line, io::to_kitti_object(box.box, frame.calibration));
      }
      lines.push_back(std::move(line));
    }
  }
  return lines;
}

class Results {
 public:
  explicit Results(const OutdoorBenchmarkOptions& options) : options_(options) {}

  void add(const Contestant& contestant, const io::KittiFrame& frame,
           const std::vector<Detection>& objects, std::vector<Detection> found) {
    add_boxes(contestant.name, contestant.box, frame.labels, result_lines(found, frame));
    if (contestant.request.quantiles.empty()) return;
    for (const double q : options_.quantiles) {
      add_boxes(contestant.name, quantile_name(q), frame.labels, quantile_lines(found, q, frame));
    }
    if (contestant.name == "gaussian") {
      auto deviating = found;
      evaluation::use_gaussian_uncertainty(deviating);
      add_uncertainty(kGaussianDeviation, objects, std::move(deviating));
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
  void add_boxes(const std::string& detector, const std::string& box,
                 const std::vector<io::KittiObject>& labels, std::vector<io::KittiObject> lines) {
    auto row = std::find_if(rows_.begin(), rows_.end(), [&](const RowFrames& one) {
      return one.detector == detector && one.box == box;
    });
    if (row == rows_.end()) row = rows_.insert(rows_.end(), {detector, box, {}});
    row->frames.push_back({.labels = labels, .predictions = std::move(lines)});
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
    const auto paths = dataset.paths(options.split, name);
    const auto objects = labelled_objects(paths, options.all_round);
    if (options.all_round) {
      frame.labels = with_ignored(std::move(frame.labels), unseen_labels(paths));
    }
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
