#include "arbox/training/pv_rcnn_training.h"

#include <ATen/Context.h>

#include <cstdint>
#include <optional>
#include <sstream>
#include <string_view>

#include "arbox/base/error.h"
#include "arbox/base/options.h"
#include "arbox/io/file.h"
#include "arbox/training/durable_file.h"
#include "arbox/training/pv_rcnn/kept_regions.h"

namespace arbox::training {
namespace {

PvRcnnTraining parse(const std::string& yaml, const std::string& source,
                     const std::vector<std::string>& overrides, PvRcnnTraining defaults) {
  return override_options(parse_options(yaml, source, std::move(defaults)), overrides);
}

/// FNV-1a.
std::uint64_t hashed(std::string_view bytes, std::uint64_t hash = 0xcbf29ce484222325) {
  for (const char byte : bytes) {
    hash = (hash ^ static_cast<unsigned char>(byte)) * 0x100000001b3;
  }
  return hash;
}

/// Names what kept regions depend on: scenes, their augmentation, and the stages before the heads.
std::string regions_name(PvRcnnTraining training) {
  const std::string initial = training.train.initial;
  // The seed decides augmentation, and weights that begin at random.
  training.train = {.seed = training.train.seed};
  training.validation = {};
  training.model.keep_regions.clear();
  training.model.losses = {};
  detectors::pv_rcnn::Options& network = training.model.network;
  network.head = {};
  network.more_heads.clear();
  network.more_head_options.clear();
  network.post = {};
  const std::uint64_t hash =
      hashed(initial.empty() ? "" : io::read_file(initial), hashed(options_yaml(training)));
  std::ostringstream name;
  name << std::hex << hash;
  return name.str();
}

}  // namespace

PvRcnnTraining read_pv_rcnn_training(const std::filesystem::path& file,
                                     const std::vector<std::string>& overrides) {
  const std::string yaml = read_options_file(file);
  PvRcnnTraining training = parse(yaml, file.string(), overrides, {});
  if (training.network_file.empty()) return training;
  PvRcnnTraining base;
  base.model.network =
      read_options<detectors::pv_rcnn::Options>(file.parent_path() / training.network_file);
  training = parse(yaml, file.string(), overrides, std::move(base));
  training.network_file.clear();
  return training;
}

std::filesystem::path configuration_file(const std::filesystem::path& folder) {
  return folder / "config.yaml";
}

TrainResult train_pv_rcnn(const PvRcnnTraining& training, const std::filesystem::path& folder,
                          bool resume, Communicator& processes, TrainObserver& observer) {
  const std::vector<std::string>& classes = training.model.network.classes;
  const auto made = make_scene_source(training.data, classes);
  if (!made) throw ConfigError("data.kind: expected kitti or street, got none");
  std::optional<pv_rcnn::KeptRegionsSource> kept;
  if (!training.model.keep_regions.empty()) {
    kept.emplace(*made,
                 std::filesystem::path(training.model.keep_regions) / regions_name(training));
  }
  const SceneSource& scenes = kept ? static_cast<const SceneSource&>(*kept) : *made;
  const auto validation = make_scene_source(training.validation, classes);
  if (!resume && processes.rank() == 0) {
    require_new_run(folder);
    write_durably(configuration_file(folder), options_yaml(training));
  }
  at::manual_seed(training.train.seed);
  PvRcnnTrainee trainee(training.model, made.get());
  return train({.trainee = trainee,
                .training = scenes,
                .validation = validation.get(),
                .options = training.train,
                .folder = folder,
                .resume = resume},
               processes, observer);
}

}  // namespace arbox::training
