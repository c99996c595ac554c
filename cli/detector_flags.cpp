#include "arbox/cli/detector_flags.h"

#include <CLI/CLI.hpp>

#include "arbox/cli/command_line.h"
#include "arbox/cli/program_registry.h"
#include "arbox/detectors/open_detector.h"

namespace arbox::cli {

namespace {

constexpr char kFallback[] = "cluster_fit";

std::vector<std::string> model_changes(const DetectorFlags& flags) {
  // --score alone says what is left out, unless --set does.
  std::vector<std::string> changes = {"post.score=0"};
  if (!flags.head.empty()) changes.push_back("post.head=" + flags.head);
  if (!flags.mode.empty()) {
    changes.push_back("post.box=" + (flags.mode == "beam" ? "mode" : flags.mode));
  }
  changes.insert(changes.end(), flags.overrides.begin(), flags.overrides.end());
  return changes;
}

/// Empty for a detector that is no model.
std::string chosen_model(const DetectorFlags& flags) {
  if (!flags.model.empty() || !flags.detector.empty()) return flags.model;
  return detectors::has_shipped_model() ? detectors::kShippedModel : "";
}

std::unique_ptr<detectors::Detector> open_chosen(const DetectorFlags& flags) {
  if (const std::string model = chosen_model(flags); !model.empty()) {
    try {
      return detectors::open_model(model, model_changes(flags));
    } catch (const detectors::OverrideError& error) {
      throw UsageError(error.what());
    }
  }
  const std::string detector = flags.detector.empty() ? kFallback : flags.detector;
  if (!flags.head.empty() || !flags.mode.empty()) {
    throw UsageError(
        "--head and --mode choose what a model answers: expected --model, got the "
        "detector " +
        detector);
  }
  try {
    return detectors::create_detector(detector, flags.config, flags.overrides, program_registry());
  } catch (const detectors::OverrideError& error) {
    throw UsageError(std::string("--set: ") + error.what());
  } catch (const InvalidArgument& error) {
    throw UsageError(error.what());
  }
}

/// Asks before the first scan is read: an empty cloud costs nothing.
void require_known_sizes(const detectors::Detector& detector, const DetectorFlags& flags) {
  if (flags.request.known_sizes.empty()) return;
  try {
    detector.detect({}, flags.request);
  } catch (const detectors::UnknownClass& error) {
    const auto line = flags.known_sizes.lines.find(error.label());
    throw FormatError(flags.known_sizes_file + ":" +
                      std::to_string(line == flags.known_sizes.lines.end() ? 0 : line->second) +
                      ": " + error.what());
  } catch (const InvalidArgument& error) {
    throw UsageError(std::string("--known-sizes: ") + error.what());
  }
}

void add_model_flags(CLI::App& command, DetectorFlags& flags) {
  CLI::Option* model =
      command
          .add_option(
              "--model", flags.model,
              "A trained detector: a .arbox file, or the name of an installed one "
              "(default: pv_rcnn_compact if it is installed, else the detector cluster_fit)")
          ->type_name("FILE|NAME");
  for (const char* other : {"--detector", "--config"}) model->excludes(command.get_option(other));
  command
      .add_option("--head", flags.head, "Which of the model's heads answers (default: its first)")
      ->type_name("NAME");
  command
      .add_option("--mode", flags.mode,
                  "The box of a detection: beam, the most likely one that a beam search finds; "
                  "mean; quantile, the quantile box of --set post.quantile=Q; pointwise (default: "
                  "as the model says)")
      ->type_name("MODE")
      ->check(CLI::IsMember({"beam", "mean", "quantile", "pointwise"}).description(""));
}

}  // namespace

std::unique_ptr<detectors::Detector> make_detector(const DetectorFlags& flags) {
  auto detector = open_chosen(flags);
  require_known_sizes(*detector, flags);
  return detector;
}

void add_detector_flags(CLI::App& command, DetectorFlags& flags) {
  CLI::Option* detector =
      command
          .add_option("--detector", flags.detector,
                      "What finds the objects, if no model: cluster_fit, or what a plugin brings "
                      "('arbox plugins list')")
          ->type_name("NAME");
  command.add_option("--config", flags.config, "Options of the detector, a YAML file")
      ->type_name("FILE")
      ->needs(detector);
  command
      .add_option("--set", flags.overrides,
                  "Options of the detector or model one by one (see 'arbox config show', 'arbox "
                  "info')")
      ->type_name("KEY=VALUE");
  add_model_flags(command, flags);
  const auto fraction = CLI::Validator(
      [](std::string& text) {
        double value = 0.0;
        const bool number = CLI::detail::lexical_cast(text, value);
        return number && value > 0.0 && value < 1.0
                   ? std::string()
                   : "expected a number between 0 and 1, got '" + text + "'";
      },
      "", "between 0 and 1");
  command.add_option("--quantile", flags.request.quantiles, "Quantile boxes at these q in (0, 1)")
      ->type_name("Q")
      ->check(fraction);
  command
      .add_option("--confidence", flags.request.confidences,
                  "Boxes that contain the object with probability p")
      ->type_name("P")
      ->check(fraction);
  command
      .add_option("--score", flags.request.score,
                  "Leave out detections with a lower score (default: 0.3)")
      ->type_name("S")
      ->check(CLI::Range(0.0, 1.0).description(""));
  command.add_option("--seed", flags.request.seed, "Seed of the box samples (default: 0)")
      ->type_name("N");
  command
      .add_option_function<std::string>(
          "--known-sizes",
          [&flags](const std::string& file) {
            flags.known_sizes_file = file;
            flags.known_sizes = io::read_known_sizes(file);
            flags.request.known_sizes = flags.known_sizes.sizes;
          },
          "Sizes that objects of some classes may have, a table of class, l, w, h, name: each "
          "object takes the likeliest one and the boxes of that size (docs/formats.md)")
      ->type_name("FILE");
  command.add_flag("--samples", flags.request.samples, "Write the box samples too");
  command
      .add_option("--channels", flags.read.channels,
                  "Columns of files that do not name theirs: number, or names in order")
      ->type_name("N|NAMES")
      ->delimiter(',');
  command
      .add_option("--input-format", flags.read.format,
                  "pcd, ply, bin, npy, npz or text, whatever the files' names say")
      ->type_name("FORMAT")
      ->check(CLI::IsMember({"pcd", "ply", "bin", "npy", "npz", "text"}).description(""));
}

}  // namespace arbox::cli
