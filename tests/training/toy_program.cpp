// Trains the toy network with the real trainer, so that tests can kill, stop and multiply it:
//
//     training_toy_program FOLDER [resume] [double] [dropout] [validate] [delay=MS] [KEY=VALUE...]
//
// or, with the word pv_rcnn, a small PV-RCNN on made scenes.
//
// Prints "step N" lines; exit code 0 at any clean end, 1 with a message for an error.
#include <ATen/Context.h>

#include <cstdio>
#include <cstdlib>
#include <exception>
#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include "arbox/base/options.h"
#include "arbox/training/gloo_communicator.h"
#include "arbox/training/pv_rcnn_trainee.h"
#include "arbox/training/stop_signals.h"
#include "arbox/training/train.h"
#include "training/made_scene.h"
#include "training/tiny_network.h"
#include "training/toy_trainee.h"

namespace {

using namespace arbox;
using namespace arbox::training;

class Printer : public TrainObserver {
 public:
  void on_step(const StepReport& report) override {
    std::printf("step %lld\n", static_cast<long long>(report.step));
    std::fflush(stdout);
  }
  bool stop_requested() override { return StopSignals::received() != 0; }
};

struct Request {
  std::string folder;
  bool resume = false;
  bool validate = false;
  bool pv_rcnn = false;
  testing::ToyOptions toy;
  TrainOptions options{.batch_size = 4, .checkpoint_seconds = 0};
};

Request parse(const std::vector<std::string>& words) {
  Request request;
  request.folder = words.at(0);
  std::vector<std::string> overrides;
  for (std::size_t i = 1; i < words.size(); ++i) {
    const std::string& word = words[i];
    if (word == "resume") {
      request.resume = true;
    } else if (word == "pv_rcnn") {
      request.pv_rcnn = true;
    } else if (word == "double") {
      request.toy.double_precision = true;
    } else if (word == "dropout") {
      request.toy.dropout = true;
    } else if (word == "validate") {
      request.validate = true;
    } else if (word.starts_with("delay=")) {
      request.toy.delay_milliseconds = std::atoi(word.c_str() + 6);
    } else {
      overrides.push_back(word);
    }
  }
  request.options = override_options(request.options, overrides);
  return request;
}

std::unique_ptr<Trainee> make_pv_rcnn(bool double_precision) {
  at::manual_seed(1);
  PvRcnnTraineeOptions options;
  options.network = tiny_network();
  options.network.head.name = "autoregressive";
  options.network.more_heads = {"gaussian", "discrete"};
  options.augmentation.objects.counts = {};
  auto trainee = std::make_unique<PvRcnnTrainee>(options);
  // Scores far apart: rounding shall not choose the proposals.
  trainee->network().named_parameters()["dense_head.conv_cls.weight"].detach().normal_(0, 0.5);
  if (double_precision) trainee->network().to(at::kDouble);
  return trainee;
}

ListedScenes made_scenes(int count) {
  std::vector<Scene> scenes;
  // Of different sizes, so that the processes do not have the same share.
  for (int i = 0; i < count; ++i) scenes.push_back(made_scene(i, 60 + 40 * i, 1000 + 500 * i));
  return ListedScenes(std::move(scenes));
}

void run(const Request& request) {
  const StopSignals signals;
  const auto processes =
      make_communicator(ProcessGroup::from_environment(), request.options.process_timeout);
  const auto made = request.pv_rcnn ? make_pv_rcnn(request.toy.double_precision)
                                    : std::make_unique<testing::ToyTrainee>(request.toy);
  Trainee& trainee = *made;
  const testing::ToyScenes toys(24);
  const ListedScenes scenes = made_scenes(request.pv_rcnn ? 6 : 0);
  const SceneSource& training = request.pv_rcnn ? static_cast<const SceneSource&>(scenes) : toys;
  const testing::ToyScenes validation(3, 2);
  Printer printer;
  const TrainResult result = train({.trainee = trainee,
                                    .training = training,
                                    .validation = request.validate ? &validation : nullptr,
                                    .options = request.options,
                                    .folder = request.folder,
                                    .resume = request.resume},
                                   *processes, printer);
  std::printf("end %d after %lld\n", static_cast<int>(result.end),
              static_cast<long long>(result.steps));
}

}  // namespace

int main(int argc, char** argv) {
  try {
    run(parse({argv + 1, argv + argc}));
    return 0;
  } catch (const std::exception& error) {
    std::cerr << error.what() << '\n';
    return 1;
  }
}
