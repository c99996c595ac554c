#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "arbox/training/pv_rcnn_trainee.h"
#include "arbox/training/scene_data.h"
#include "arbox/training/train.h"

namespace arbox::training {

/// A training run of PV-RCNN: what `arbox train` reads.
struct PvRcnnTraining {
  std::string network_file;
  PvRcnnTraineeOptions model;
  SceneDataOptions data;
  SceneDataOptions validation = {.kind = "none", .kitti = {}, .street = {}};
  TrainOptions train;

  template <class Visitor>
  static void describe(Visitor& visitor) {
    visitor.field("network_file", &PvRcnnTraining::network_file,
                  {.help = "YAML file with options of the network, from the folder of this file; "
                           "keys of model.network change it"});
    visitor.group("model", &PvRcnnTraining::model, "The network and how it learns");
    visitor.group("data", &PvRcnnTraining::data, "Scenes to learn from");
    visitor.group("validation", &PvRcnnTraining::validation, "Scenes to validate on");
    visitor.group("train", &PvRcnnTraining::train, "The run");
  }
};

/// Reads a run's configuration, changed by KEY=VALUE overrides. The result holds the network file's
/// options and names no file any more. Throws IoError, ConfigError.
PvRcnnTraining read_pv_rcnn_training(const std::filesystem::path& file,
                                     const std::vector<std::string>& overrides = {});

/// The folder's copy of the configuration.
std::filesystem::path configuration_file(const std::filesystem::path& folder);

/// Trains (training/train.h) in `folder`; a new run keeps its configuration there. Throws
/// ConfigError too if the configuration names no data.
TrainResult train_pv_rcnn(const PvRcnnTraining& training, const std::filesystem::path& folder,
                          bool resume, Communicator& processes, TrainObserver& observer);

}  // namespace arbox::training
