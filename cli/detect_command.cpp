#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <filesystem>
#include <iostream>
#include <memory>

#include "arbox/cli/command_line.h"
#include "arbox/cli/commands.h"
#include "arbox/cli/detection_output.h"
#include "arbox/cli/detector_flags.h"
#include "arbox/cli/frame_stream.h"
#include "arbox/cli/progress.h"
#include "arbox/cli/scan_inputs.h"

namespace arbox::cli {
namespace {

struct DetectFlags : DetectorFlags {
  std::vector<std::string> inputs;
  std::string split;
  bool frames = false;
  OutputOptions output;
};

/// What could not be read or written; told at once, counted for the exit code.
class Failures {
 public:
  void add(const std::exception& error) {
    spdlog::error("{}", fold_lines(error.what()));
    ++count_;
  }
  std::size_t count() const { return count_; }

 private:
  std::size_t count_ = 0;
};

void detect_frames(const DetectFlags& flags) {
  if (!flags.inputs.empty()) {
    throw UsageError("--stdin: the points come on standard input, got " + flags.inputs[0] + " too");
  }
  const auto detector = make_detector(flags);
  const FrameCount count = answer_frames(std::cin, std::cout, *detector, flags.request, flags.read);
  if (count.refused > 0) {
    throw Error(std::to_string(count.refused) + " of " + std::to_string(count.frames) +
                " frames refused");
  }
}

void detect(const DetectFlags& flags) {
  if (flags.frames) {
    detect_frames(flags);
    return;
  }
  if (flags.inputs.empty()) throw UsageError("input: expected at least one file or folder");
  const auto detector = make_detector(flags);
  Failures failures;
  const std::vector<ScanInput> scans =
      list_scans(flags.inputs, flags.split, [&](const Error& error) { failures.add(error); });
  const std::size_t inputs = scans.size() + failures.count();
  const bool several = flags.inputs.size() > 1 || std::filesystem::is_directory(flags.inputs[0]);
  DetectionOutput output(flags.output, scans, several);
  {
    Progress progress("detect", static_cast<std::int64_t>(scans.size()));
    for (const ScanInput& scan : scans) {
      try {
        const auto start = std::chrono::steady_clock::now();
        const io::PointCloudFile file = read_scan(scan, flags.read);
        const geometry::PointCloudView cloud = file.points.view();
        const auto read = std::chrono::steady_clock::now();
        detectors::DetectionResult result = detector->detect(cloud, flags.request);
        const auto found = std::chrono::steady_clock::now();
        output.write(scan, std::move(result.detections), cloud);
        const auto milliseconds = [](auto time) {
          return std::chrono::duration<double, std::milli>(time).count();
        };
        spdlog::debug(
            "{}: {} points, {} without finite coordinates; read {:.1f} ms, detect {:.1f} ms",
            scan.source, cloud.size(), file.dropped + result.dropped_points,
            milliseconds(read - start), milliseconds(found - read));
      } catch (const UsageError&) {
        throw;
      } catch (const Error& error) {
        if (!several) throw;
        failures.add(error);
      }
      progress.advance();
    }
  }
  output.finish();
  if (failures.count() > 0) {
    throw Error(std::to_string(failures.count()) + " of " + std::to_string(inputs) +
                " inputs failed");
  }
}

}  // namespace

void add_detect(CLI::App& app) {
  auto flags = std::make_shared<DetectFlags>();
  CLI::App* command = app.add_subcommand("detect", "Find the objects in point clouds");
  command
      ->add_option("input", flags->inputs,
                   "Point-cloud files, folders of them, or with --split roots of KITTI datasets; - "
                   "reads standard input")
      ->type_name("INPUT");
  command
      ->add_option("--split", flags->split,
                   "Look at the scans of this split of a KITTI root; --format kitti takes each "
                   "frame's calibration")
      ->type_name("NAME");
  add_detector_flags(*command, *flags);
  command
      ->add_option("--output", flags->output.folder,
                   "Folder to write one file a scan into (default: standard output)")
      ->type_name("DIR");
  command
      ->add_option("--format", flags->output.format,
                   "json, jsonl, kitti, csv or ply (default: json)")
      ->type_name("FORMAT")
      ->check(CLI::IsMember({"json", "jsonl", "kitti", "csv", "ply"}).description(""));
  command
      ->add_option("--calib", flags->output.calibration,
                   "KITTI calibration, or a folder of them, for --format kitti")
      ->type_name("FILE|DIR");
  command
      ->add_option("--view", flags->output.view,
                   "Draw the scan and its boxes (a folder if there are several scans)")
      ->type_name("PNG");
  CLI::Option* frames = command->add_flag(
      "--stdin", flags->frames,
      "Answer frames of points on standard input with a line of JSON each (docs/formats.md)");
  for (const char* other :
       {"--split", "--output", "--format", "--calib", "--view", "--input-format"}) {
    frames->excludes(command->get_option(other));
  }
  command->callback([flags] { detect(*flags); });
  add_examples(*command,
               {{"arbox detect scan.pcd", "JSON on standard output"},
                {"arbox detect scan.pcd --model car.arbox --mode mean --quantile 0.2",
                 "a trained network in place of the classical baseline"},
                {"arbox detect 000008.bin --quantile 0.1 0.5 --view boxes.png",
                 "quantile boxes and a picture"},
                {"arbox detect kitti --split val --format kitti --score 0 --output results",
                 "result files of a split, which 'arbox evaluate kitti' reads"},
                {"arbox detect fleet.pcd --model car.arbox --known-sizes models.csv",
                 "boxes of the sizes that the cars of a fleet have"},
                {"arbox detect velodyne --format kitti --calib calib --score 0 --output results",
                 "result files that 'arbox evaluate kitti' reads"},
                {"cat scan.bin | arbox detect - --input-format bin --format csv", "in a pipe"},
                {"lidar_driver | arbox detect --stdin", "scan after scan from another program"}});
}

}  // namespace arbox::cli
