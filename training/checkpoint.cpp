#include "arbox/training/checkpoint.h"

#include <nlohmann/json.hpp>

#include "arbox/base/error.h"
#include "arbox/base/options.h"
#include "arbox/detectors/model_file.h"
#include "arbox/io/model_archive.h"
#include "arbox/training/durable_file.h"

namespace arbox::training {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kCheckpointKind = "training_checkpoint";
constexpr const char* kState = "state.json";

std::string state_text(const Checkpoint& checkpoint) {
  return Json{{"step", checkpoint.step},           {"validated", checkpoint.validated},
              {"skipped", checkpoint.skipped},     {"skipped_in_row", checkpoint.skipped_in_row},
              {"seconds", checkpoint.seconds},     {"best", checkpoint.best},
              {"best_step", checkpoint.best_step}, {"scenes", checkpoint.scenes}}
             .dump(2) +
         "\n";
}

void read_state(const std::string& text, Checkpoint& checkpoint) {
  const Json state = Json::parse(text);
  state.at("step").get_to(checkpoint.step);
  state.at("validated").get_to(checkpoint.validated);
  state.at("skipped").get_to(checkpoint.skipped);
  state.at("skipped_in_row").get_to(checkpoint.skipped_in_row);
  state.at("seconds").get_to(checkpoint.seconds);
  state.at("best").get_to(checkpoint.best);
  state.at("best_step").get_to(checkpoint.best_step);
  state.at("scenes").get_to(checkpoint.scenes);
}

}  // namespace

std::filesystem::path checkpoint_file(const std::filesystem::path& folder) {
  return folder / "checkpoint.arbox";
}

void write_checkpoint(const std::filesystem::path& path, const Checkpoint& checkpoint) {
  io::ModelArchive archive;
  archive.kind = kCheckpointKind;
  archive.configuration = options_yaml(checkpoint.options);
  archive.texts[kState] = state_text(checkpoint);
  for (const auto& [name, tensor] : checkpoint.tensors) {
    archive.records[name] = detectors::to_record(tensor);
  }
  write_durably(path, io::encode_model_archive(archive));
}

Checkpoint read_checkpoint(const std::filesystem::path& path) {
  const io::ModelArchive archive = io::read_model_archive(path);
  const auto state = archive.texts.find(kState);
  if (archive.kind != kCheckpointKind || state == archive.texts.end()) {
    throw FormatError(path.string() +
                      ": expected the checkpoint of a training run, got a file of "
                      "kind '" +
                      archive.kind + "'");
  }
  Checkpoint checkpoint;
  checkpoint.options = parse_options<TrainOptions>(archive.configuration, path.string());
  try {
    read_state(state->second, checkpoint);
  } catch (const nlohmann::json::exception& error) {
    throw FormatError(path.string() + ": " + kState + ": " + error.what());
  }
  for (const auto& [name, record] : archive.records) {
    checkpoint.tensors[name] = detectors::to_tensor(record, name);
  }
  return checkpoint;
}

}  // namespace arbox::training
