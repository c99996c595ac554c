#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <filesystem>
#include <memory>

#include "arbox/base/plugin_loader.h"
#include "arbox/cli/command_line.h"
#include "arbox/cli/commands.h"
#include "arbox/cli/detection_output.h"
#include "arbox/cli/program_registry.h"
#include "arbox/cli/progress.h"
#include "arbox/cli/standard_input.h"
#include "arbox/detectors/detector_kind.h"
#include "arbox/io/point_cloud_file.h"

namespace arbox::cli {
namespace {

struct DetectFlags {
  std::vector<std::string> inputs;
  std::string detector = "cluster_fit";
  std::string config;
  std::vector<std::string> overrides;
  detectors::DetectionRequest request{.score = 0.3};
  io::ReadOptions read;
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

std::unique_ptr<detectors::Detector> make_detector(const DetectFlags& flags) {
  using Kind = detectors::DetectorKind;
  Registry& registry = program_registry();
  try {
    require_plugin(Kind::kName, flags.detector, registry);
  } catch (const PluginError& error) {
    const auto found = find_plugins();
    const std::string file = "libarbox_detector_" + flags.detector + ".so";
    if (std::any_of(found.begin(), found.end(),
                    [&](const auto& path) { return path.filename() == file; })) {
      throw;
    }
    throw UsageError(error.what());
  }
  const OptionsInstance options = registry.find(Kind::kName, flags.detector).options();
  if (!flags.config.empty()) {
    assign_yaml(options.fields, read_options_file(flags.config), flags.config);
  }
  try {
    assign_overrides(options.fields, flags.overrides);
  } catch (const ConfigError& error) {
    throw UsageError(std::string("--set: ") + error.what());
  }
  return registry.create<Kind>(flags.detector, options);
}

/// The files of the inputs, folders opened.
std::vector<std::string> list_scans(const std::vector<std::string>& inputs, Failures& failures) {
  std::vector<std::string> scans;
  for (const std::string& input : inputs) {
    if (!std::filesystem::is_directory(input)) {
      scans.push_back(input);
      continue;
    }
    try {
      const auto files = io::list_point_clouds(input);
      if (files.empty()) throw IoError(input + ": holds no point clouds");
      for (const auto& file : files) scans.push_back(file.string());
    } catch (const IoError& error) {
      if (inputs.size() == 1) throw;
      failures.add(error);
    }
  }
  return scans;
}

void detect(const DetectFlags& flags) {
  const auto detector = make_detector(flags);
  Failures failures;
  const std::vector<std::string> scans = list_scans(flags.inputs, failures);
  const std::size_t inputs = scans.size() + failures.count();
  const bool several = flags.inputs.size() > 1 || std::filesystem::is_directory(flags.inputs[0]);
  DetectionOutput output(flags.output, scans, several);
  {
    Progress progress("detect", static_cast<std::int64_t>(scans.size()));
    for (const std::string& scan : scans) {
      try {
        const auto start = std::chrono::steady_clock::now();
        const io::PointCloudFile file = read_point_cloud_input(scan, flags.read);
        const geometry::PointCloudView cloud = file.points.view();
        const auto read = std::chrono::steady_clock::now();
        detectors::DetectionResult result = detector->detect(cloud, flags.request);
        const auto found = std::chrono::steady_clock::now();
        output.write({.source = scan, .detections = std::move(result.detections)}, cloud);
        const auto milliseconds = [](auto time) {
          return std::chrono::duration<double, std::milli>(time).count();
        };
        spdlog::debug(
            "{}: {} points, {} without finite coordinates; read {:.1f} ms, detect {:.1f} ms", scan,
            cloud.size(), file.dropped + result.dropped_points, milliseconds(read - start),
            milliseconds(found - read));
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
                   "Point-cloud files or folders of them; - reads standard input")
      ->type_name("INPUT")
      ->required();
  command
      ->add_option("--detector", flags->detector,
                   "What finds them (default: cluster_fit; 'arbox plugins list' lists all)")
      ->type_name("NAME");
  command->add_option("--config", flags->config, "Options of the detector, a YAML file")
      ->type_name("FILE");
  command
      ->add_option("--set", flags->overrides,
                   "Options of the detector one by one (see 'arbox config show')")
      ->type_name("KEY=VALUE");
  const auto fraction = CLI::Validator(
      [](std::string& text) {
        double value = 0.0;
        const bool number = CLI::detail::lexical_cast(text, value);
        return number && value > 0.0 && value < 1.0
                   ? std::string()
                   : "expected a number between 0 and 1, got '" + text + "'";
      },
      "", "between 0 and 1");
  command->add_option("--quantile", flags->request.quantiles, "Quantile boxes at these q in (0, 1)")
      ->type_name("Q")
      ->check(fraction);
  command
      ->add_option("--confidence", flags->request.confidences,
                   "Boxes that contain the object with probability p")
      ->type_name("P")
      ->check(fraction);
  command
      ->add_option("--score", flags->request.score,
                   "Leave out detections with a lower score (default: 0.3)")
      ->type_name("S")
      ->check(CLI::Range(0.0, 1.0).description(""));
  command->add_option("--seed", flags->request.seed, "Seed of the box samples (default: 0)")
      ->type_name("N");
  command->add_flag("--samples", flags->request.samples, "Write the box samples too");
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
  command
      ->add_option("--channels", flags->read.channels,
                   "Columns of files that do not name theirs: number, or names in order")
      ->type_name("N|NAMES")
      ->delimiter(',');
  command
      ->add_option("--input-format", flags->read.format,
                   "pcd, ply, bin, npy, npz or text, whatever the files' names say")
      ->type_name("FORMAT")
      ->check(CLI::IsMember({"pcd", "ply", "bin", "npy", "npz", "text"}).description(""));
  command->callback([flags] { detect(*flags); });
  add_examples(*command,
               {{"arbox detect scan.pcd", "JSON on standard output"},
                {"arbox detect 000008.bin --quantile 0.1 0.5 --view boxes.png",
                 "quantile boxes and a picture"},
                {"arbox detect velodyne --format kitti --calib calib --score 0 --output results",
                 "result files that 'arbox evaluate kitti' reads"},
                {"cat scan.bin | arbox detect - --input-format bin --format csv", "in a pipe"}});
}

}  // namespace arbox::cli
