#include <CLI/CLI.hpp>
#include <filesystem>
#include <iostream>
#include <memory>

#include "arbox/cli/command_line.h"
#include "arbox/cli/commands.h"
#include "arbox/cli/evaluation_figure.h"
#include "arbox/cli/outdoor_benchmark.h"
#include "arbox/drawing/image.h"
#include "arbox/io/file.h"

namespace arbox::cli {
namespace {

struct BenchmarkFlags {
  OutdoorBenchmarkOptions options;
  std::filesystem::path output;
  bool json = false;
};

void write_results(const OutdoorBenchmark& benchmark, const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) throw IoError(folder.string() + ": cannot be made: " + error.message());
  io::write_file(folder / "benchmark.json", to_json(benchmark));
  io::write_file(folder / "benchmark.md", to_markdown(benchmark));
  drawing::write_image(draw_average_precision(benchmark), folder / "average_precision.png");
  drawing::write_image(draw_promises(benchmark.uncertainty, benchmark.title),
                       folder / "promises.png");
  for (const BenchmarkRow& row : benchmark.rows) {
    const std::string name = "precision_recall_" + row.detector + ".png";
    if (row.box.starts_with("q ") || row.box == "mean") continue;
    drawing::write_image(draw_precision_recall(row.iou), folder / name);
  }
}

void run_benchmark(const BenchmarkFlags& flags) {
  const OutdoorBenchmark benchmark = run_outdoor_benchmark(flags.options);
  if (!flags.output.empty()) write_results(benchmark, flags.output);
  std::cout << (flags.json ? to_json(benchmark) : to_markdown(benchmark));
}

}  // namespace

void add_benchmark(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "benchmark",
      "Compare heads, kinds of boxes and the classical baseline on labelled scans: precision, "
      "promises, uncertainty, speed");
  const auto flags = std::make_shared<BenchmarkFlags>();
  OutdoorBenchmarkOptions& options = flags->options;
  command->add_option("--data", options.data, "Labelled scans in KITTI's layout")
      ->required()
      ->check(CLI::ExistingDirectory)
      ->type_name("ROOT");
  command->add_option("--split", options.split, "Split of the scans")->capture_default_str();
  command
      ->add_option("--scans", options.scans, "Scans at most, the first of the split (default: all)")
      ->check(CLI::PositiveNumber)
      ->type_name("N");
  command->add_flag(
      "--all-round", options.all_round,
      "Promises and uncertainty in all directions: also on the objects that the camera "
      "does not see, of ROOT/training/label_360, as 'arbox simulate street' writes "
      "them");
  command
      ->add_option("--model", options.model,
                   "A trained detector: a .arbox file, or the name of an installed one")
      ->type_name("FILE|NAME");
  command->add_option("--heads", options.heads, "Heads of the model (default: all)")
      ->type_name("NAME");
  command->add_flag("!--no-cluster-fit", options.cluster_fit, "Leave out the classical baseline");
  command->add_option("--quantile", options.quantiles, "Quantile boxes at these q in (0, 1)")
      ->check(CLI::Range(0.001, 0.999))
      ->type_name("Q")
      ->capture_default_str();
  command
      ->add_option("--confidence", options.confidences,
                   "Boxes that contain the object with probability p, from the model's first head "
                   "(calibrated models)")
      ->check(CLI::Range(0.001, 0.999))
      ->type_name("P");
  command->add_option("--score", options.score, "Least score of what counts for average precision")
      ->check(CLI::Range(0.0, 1.0))
      ->capture_default_str();
  command
      ->add_option("--found-score", options.found_score,
                   "Least score of what counts for promises and uncertainty")
      ->check(CLI::Range(0.0, 1.0))
      ->capture_default_str();
  command
      ->add_option("--timed", options.timed,
                   "Scans that each kind of box is timed on, alone; 0: no timing")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  command
      ->add_option("--output", flags->output,
                   "Folder for benchmark.json, benchmark.md and the pictures")
      ->type_name("DIR");
  add_json_flag(*command, flags->json);
  add_examples(*command, {{"arbox benchmark --data /data/kitti --model pv_rcnn_compact --output "
                           "results",
                           "The whole outdoor benchmark on KITTI's validation split"},
                          {"arbox benchmark --data streets --all-round --model run/model.arbox "
                           "--scans 100",
                           "On simulated streets"}});
  command->callback([flags] { run_benchmark(*flags); });
}

}  // namespace arbox::cli
