#include "arbox/training/pv_rcnn_training.h"

#include <ATen/Context.h>

#include "arbox/base/error.h"
#include "arbox/base/options.h"
#include "arbox/training/durable_file.h"

namespace arbox::training {
namespace {

PvRcnnTraining parse(const std::string& yaml, const std::string& source,
                     const std::vector<std::string>& overrides, PvRcnnTraining defaults) {
  return override_options(parse_options(yaml, source, std::move(defaults)), overrides);
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
  const auto scenes = make_scene_source(training.data, classes);
  if (!scenes) throw ConfigError("data.kind: expected kitti or street, got none");
  const auto validation = make_scene_source(training.validation, classes);
  if (!resume && processes.rank() == 0) {
    require_new_run(folder);
    write_durably(configuration_file(folder), options_yaml(training));
  }
  at::manual_seed(training.train.seed);
  PvRcnnTrainee trainee(training.model, scenes.get());
  return train({.trainee = trainee,
                .training = *scenes,
                .validation = validation.get(),
                .options = training.train,
                .folder = folder,
                .resume = resume},
               processes, observer);
}

}  // namespace arbox::training
