#include "arbox/base/options.h"
#include "arbox/cli/torch_module.h"
#include "arbox/cli/torch_training.h"
#include "arbox/detectors/pv_rcnn/import_openpcdet.h"
#include "arbox/heads/conditioning.h"
#include "arbox/heads/fit_ranges.h"
#include "arbox/heads/head_kind.h"
#include "arbox/training/checkpoint.h"
#include "arbox/training/pv_rcnn_training.h"
#include "arbox/training/weights_file.h"

namespace arbox::heads {
void register_heads(Registrar& registrar);  // head_registry.h, without LibTorch's headers
}

namespace arbox::cli {
namespace {

void register_built_ins(Registry& registry) {
  heads::declare_heads(registry);
  registry.add_built_in(heads::register_heads);
}

OptionsMaker find_options(std::string_view name) {
  if (name == "codec") return &make_options<heads::CodecOptions>;
  if (name == "conditioning") return &make_options<heads::ConditioningOptions>;
  if (name == "train/pv_rcnn") return &make_training_options;
  return nullptr;
}

FitBinsResult fit_bins(const FitBinsRequest& request) {
  const auto codec = override_options(heads::CodecOptions(), request.codec);
  const heads::References references =
      heads::simulated_references(request.boxes, codec.kind, request.draws, request.seed);
  std::vector<geometry::Box> boxes;
  for (int draw = 0; draw < request.draws; ++draw) {
    boxes.insert(boxes.end(), request.boxes.begin(), request.boxes.end());
  }
  const heads::RangeFit fit = heads::fit_ranges(boxes, references, codec);
  return {options_yaml(fit.codec), fit.mean_iou, fit.overflow, fit.reached};
}

ImportResult import_openpcdet(const ImportRequest& request) {
  namespace pv_rcnn = detectors::pv_rcnn;
  auto options = override_options(pv_rcnn::ImportOptions(), request.options);
  options.overrides = request.overrides;
  if (!request.configuration.empty()) {
    options.network = read_options<pv_rcnn::Options>(request.configuration);
  }
  const auto [model, report] = pv_rcnn::import_openpcdet(request.checkpoint, options);
  pv_rcnn::save_model(
      request.output, *model.network, model.notes,
      request.half ? detectors::WeightPrecision::kHalf : detectors::WeightPrecision::kFull);
  options.layout = report.layout;
  const auto& network = model.network->options();
  return {.head = network.head.name,
          .layout = option_text(bind_options(options).fields.front()),
          .classes = network.classes,
          .entries = report.entries,
          .parameters = report.parameters,
          .unused = report.unused};
}

std::vector<ModelHead> model_heads(const std::string& file) {
  std::vector<ModelHead> heads;
  const auto model = detectors::pv_rcnn::load_model(file);
  const auto nothing = model.network->no_head_input();
  for (const auto& [name, head] : model.network->heads()) {
    const bool has_distribution = head->forward(nothing)->measure() != heads::Measure::kNone;
    heads.push_back({.name = name, .has_distribution = has_distribution});
  }
  return heads;
}

/// The network of a training run as its last checkpoint has it.
detectors::pv_rcnn::Model model_of_run(const std::filesystem::path& folder,
                                       const std::vector<std::string>& overrides) {
  const auto training = training::read_pv_rcnn_training(training::configuration_file(folder));
  const auto network = std::make_shared<detectors::pv_rcnn::Network>(
      override_options(training.model.network, overrides));
  training::load_weights(*network, training::checkpoint_file(folder));
  network->eval();
  return {.network = network, .notes = {}};
}

void pack(const PackRequest& request) {
  namespace pv_rcnn = detectors::pv_rcnn;
  pv_rcnn::Model model = std::filesystem::is_directory(request.model)
                             ? model_of_run(request.model, request.overrides)
                             : pv_rcnn::load_model(request.model, request.overrides);
  if (!request.average.empty()) {
    training::average_weights(*model.network, request.average, request.share,
                              request.average_except);
    model.notes.calibration.reset();
  }
  if (!request.card.empty()) model.notes.card = request.card;
  pv_rcnn::save_model(
      request.output, *model.network, model.notes,
      request.half ? detectors::WeightPrecision::kHalf : detectors::WeightPrecision::kFull);
}

}  // namespace
}  // namespace arbox::cli

extern "C" __attribute__((visibility("default"))) const arbox::cli::TorchModule*
arbox_torch_module() {
  using namespace arbox;
  static const cli::TorchModule module = {&cli::register_built_ins,
                                          &cli::find_options,
                                          &cli::fit_bins,
                                          &cli::import_openpcdet,
                                          &cli::train,
                                          &cli::model_heads,
                                          &cli::pack};
  return &module;
}

/// For detectors/open_detector.h.
extern "C" __attribute__((visibility("default"))) void arbox_load_detector(
    const std::string& file, const std::vector<std::string>& overrides,
    std::unique_ptr<arbox::detectors::Detector>& result) {
  result = arbox::detectors::pv_rcnn::load_pv_rcnn(file, overrides);
}
