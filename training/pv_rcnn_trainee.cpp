#include "arbox/training/pv_rcnn_trainee.h"

#include <ATen/TensorOperators.h>
#include <ATen/ops/arange.h>
#include <ATen/ops/scalar_tensor.h>
#include <ATen/ops/zeros.h>
#include <torch/csrc/autograd/grad_mode.h>

#include <algorithm>
#include <optional>
#include <utility>

#include "arbox/base/error.h"
#include "arbox/base/options.h"
#include "arbox/detectors/pv_rcnn/box_coding.h"
#include "arbox/detectors/pv_rcnn/model.h"
#include "arbox/training/pv_rcnn/evaluation.h"
#include "arbox/training/pv_rcnn/kept_regions.h"

namespace arbox::training {

using at::Tensor;
using namespace detectors::pv_rcnn;

namespace {

/// What a sum of losses is divided by.
enum Count { kScans, kKeypoints, kConfidences, kForeground, kCounts };

bool learns(const torch::nn::Module& module) {
  const auto parameters = module.parameters();
  return std::any_of(parameters.begin(), parameters.end(),
                     [](const Tensor& one) { return one.requires_grad(); });
}

/// Runs `work` with gradients or without.
template <class Work>
auto with_gradient(bool gradient, const Work& work) {
  std::optional<torch::NoGradGuard> guard;
  if (!gradient) guard.emplace();
  return work();
}

std::vector<pv_rcnn::AnchorRule> rules_of(const AnchorOptions& anchors) {
  std::vector<pv_rcnn::AnchorRule> rules;
  for (std::size_t i = 0; i < anchors.positive_iou.size(); ++i) {
    rules.push_back({anchors.positive_iou[i], anchors.negative_iou[i]});
  }
  return rules;
}

void require_heads_alone(bool others_learn) {
  if (!others_learn) return;
  throw ConfigError(
      "model.keep_regions: expected heads alone to be trained; name all other parts in "
      "train.frozen (docs/training.md has the list)");
}

void require_valid(const PvRcnnTraineeOptions& options) {
  validate_options(options, "pv_rcnn training");
  const std::size_t pasted = options.augmentation.objects.counts.size();
  if (options.augmentation.enabled && pasted > options.network.classes.size()) {
    throw ConfigError("augmentation.objects.counts: expected at most one number for each of " +
                      std::to_string(options.network.classes.size()) + " classes, got " +
                      std::to_string(pasted));
  }
}

}  // namespace

/// What is known of a batch on its way through the network.
struct PvRcnnTrainee::Pass {
  Pass(Parts what, pv_rcnn::SceneObjects sought) : parts(what), objects(std::move(sought)) {}

  struct Term {
    Tensor sum;
    double weight;
    Count count;
  };
  Parts parts;
  pv_rcnn::SceneObjects objects;
  std::optional<PointBatch> batch;
  FirstStage first;
  pv_rcnn::ProposalTargets drawn;
  SecondStage second;
  std::map<std::string, Term> terms;
  /// Sums over the foreground that are told, without gradient.
  std::map<std::string, double> told;
  Tensor counts = at::zeros({kCounts}, at::kDouble);
  /// Of this process.
  double foreground = 0;

  void count(Count which, double number) { counts[which] = number; }
};

PvRcnnTrainee::PvRcnnTrainee(PvRcnnTraineeOptions options, const SceneSource* objects)
    : options_(std::move(options)) {
  require_valid(options_);
  const Options& network = options_.network;
  network_ = std::make_shared<Network>(network);
  assigner_ = std::make_unique<pv_rcnn::AnchorAssigner>(
      network_->anchors(), rules_of(network.anchors),
      static_cast<std::int64_t>(network.anchors.rotations.size()), options_.ignore_similar);
  const AugmentationOptions& augmentation = options_.augmentation;
  if (objects != nullptr && augmentation.enabled && !augmentation.objects.counts.empty()) {
    database_ =
        std::make_unique<ObjectDatabase>(ObjectDatabase::build(*objects, augmentation.database));
  }
}

PvRcnnTrainee::~PvRcnnTrainee() = default;

void PvRcnnTrainee::prepare(Scene& scene, std::uint64_t seed, std::int64_t place) const {
  if (scene.regions) return;
  augment(scene, options_.augmentation, database_.get(), seed, place);
}

PvRcnnTrainee::Parts PvRcnnTrainee::parts() const {
  Parts result;
  for (const auto& child : network_->named_children()) {
    const std::string& name = child.key();
    if (name == "backbone_3d" || name == "backbone_2d" || name == "dense_head") {
      result.first_stage = result.first_stage || learns(*child.value());
    } else if (name == "roi_head") {
      for (const auto& part : child.value()->named_children()) {
        if (part.key() != "box_head") {
          result.refinement = result.refinement || learns(*part.value());
        }
      }
    } else if (name != "box_heads") {
      result.refinement = result.refinement || learns(*child.value());
    }
  }
  for (const auto& [name, head] : network_->heads()) result.heads = result.heads || learns(*head);
  return result;
}

pv_rcnn::SceneObjects PvRcnnTrainee::objects_in_range(std::span<const Scene> scenes) const {
  const VoxelOptions& range = options_.network.voxels;
  const auto inside = [&](const SceneObject& object) {
    for (int axis = 0; axis < 3; ++axis) {
      const double place = object.box.center[axis];
      if (place < range.low[axis] || place > range.high[axis]) return false;
    }
    return true;
  };
  pv_rcnn::SceneObjects result;
  for (const Scene& scene : scenes) {
    auto& objects = result.emplace_back();
    std::copy_if(scene.objects.begin(), scene.objects.end(), std::back_inserter(objects), inside);
  }
  return result;
}

void PvRcnnTrainee::first_stage_terms(Pass& pass) const {
  std::vector<pv_rcnn::AnchorTargets> targets;
  std::int64_t start = 0;
  for (std::size_t scan = 0; scan < pass.objects.size(); ++scan) {
    const std::int64_t end = start + pass.first.counts[scan];
    targets.push_back(
        assigner_->assign(pass.objects[scan], pass.first.anchors.slice(0, start, end)));
    start = end;
  }
  const pv_rcnn::LossOptions& losses = options_.losses;
  const auto sums =
      pv_rcnn::first_stage_losses(pass.first, network_->anchors(), targets, pass.objects,
                                  options_.network.anchors.direction_offset, losses);
  pass.terms["classification"] = {sums.at("classification"), losses.classification, kScans};
  pass.terms["box"] = {sums.at("box"), losses.box, kScans};
  pass.terms["direction"] = {sums.at("direction"), losses.direction, kScans};
}

void PvRcnnTrainee::second_stage_terms(Pass& pass, const Step& step) {
  const Proposals proposals = network_->propose(pass.first, options_.network.training_proposals);
  pass.drawn = pv_rcnn::draw_proposals(proposals, pass.objects, options_.proposals,
                                       options_.ignore_similar, step.seed, step.first_scene);
  const auto& [boxes, labels, scene, iou, confidence, foreground, found] = pass.drawn;
  const bool gradient = pass.parts.refinement || pass.parts.first_stage;
  Keypoints keypoints;
  with_gradient(gradient, [&] {
    keypoints = network_->keypoints(*pass.batch, pass.first, boxes, scene);
    pass.second = network_->second_stage(keypoints, boxes, scene);
  });
  pass.count(kConfidences, (confidence >= 0).sum().item<double>());
  pass.count(kForeground, static_cast<double>(foreground.numel()));
  if (!pass.parts.refinement) return;
  const pv_rcnn::LossOptions& losses = options_.losses;
  const Tensor targets = pv_rcnn::keypoint_targets(keypoints.points, keypoints.counts, pass.objects,
                                                   options_.keypoint_ring, options_.ignore_similar);
  pass.count(kKeypoints, (targets > 0).sum().item<double>());
  pass.terms["keypoint"] = {pv_rcnn::keypoint_loss(keypoints.logits, targets, losses),
                            losses.keypoint, kKeypoints};
  const auto sums = pv_rcnn::second_stage_losses(pass.second, pass.drawn, losses);
  pass.terms["confidence"] = {sums.at("confidence"), losses.confidence, kConfidences};
  pass.terms["residual"] = {sums.at("residual"), losses.residual, kForeground};
  pass.terms["corner"] = {sums.at("corner"), losses.corner, kForeground};
}

heads::HeadInput PvRcnnTrainee::drawn_input(const Pass& pass, const Step& step) const {
  heads::HeadInput input =
      network_->head_input(pass.second, pass.drawn.boxes).select(pass.drawn.foreground);
  if (options_.detach_heads) {
    input.features = input.features.detach();
    input.condition = input.condition.detach();
  }
  input.seed = step.seed;
  input.object_ids = (pass.drawn.scene + step.first_scene).index_select(0, pass.drawn.foreground) *
                         options_.proposals.count +
                     pass.drawn.foreground % options_.proposals.count;
  return input;
}

void PvRcnnTrainee::kept_terms(Pass& pass, std::span<const Scene> scenes, const Step& step) {
  std::vector<std::shared_ptr<const pv_rcnn::KeptRegions>> parts;
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    const Scene& scene = scenes[i];
    parts.push_back(scene.regions);
    if (scene.regions) continue;
    const auto found = std::make_shared<pv_rcnn::KeptRegions>(pv_rcnn::detected_regions(
        *network_, scene, pass.objects[i], options_.proposals.foreground_iou));
    if (!scene.regions_file.empty()) pv_rcnn::write_kept_regions(scene.regions_file, *found);
    parts.back() = found;
  }
  const pv_rcnn::KeptRegions regions = pv_rcnn::joined(parts);
  const std::int64_t count = regions.boxes.size(0);
  pass.count(kForeground, static_cast<double>(count));
  pass.foreground = static_cast<double>(count);
  heads::HeadInput input =
      network_->head_input({regions.features, {}, regions.residuals}, regions.boxes);
  input.seed = step.seed;
  input.object_ids = at::arange(count, at::kLong) + step.first_scene * options_.proposals.count;
  head_terms(pass, input, regions.objects);
}

void PvRcnnTrainee::head_terms(Pass& pass, const heads::HeadInput& input, const Tensor& objects) {
  const Tensor targets = to_box_rows(objects).to(input.features.scalar_type());
  for (const auto& [name, head] : network_->heads()) {
    // The pointwise branch learns from the losses of its residuals.
    if (head->parameters().empty() || (!learns(*head) && !pass.parts.refinement)) continue;
    const heads::HeadLoss loss = head->loss(input, targets);
    pass.terms["head " + name] = {loss.per_object.sum(), options_.losses.head, kForeground};
    for (const auto& [part, values] : loss.terms) {
      pass.told[name + " " + part] = values.sum().item<double>();
    }
  }
}

void PvRcnnTrainee::network_terms(Pass& pass, std::span<const Scene> scenes, const Step& step) {
  std::vector<geometry::PointCloudView> clouds;
  for (const Scene& scene : scenes) clouds.push_back(scene.cloud.view());
  pass.batch = make_batch(clouds, options_.network, true, step.seed,
                          static_cast<std::uint64_t>(step.first_scene));
  with_gradient(pass.parts.first_stage, [&] { pass.first = network_->first_stage(*pass.batch); });
  if (pass.parts.first_stage) first_stage_terms(pass);
  if (!pass.parts.refinement && !pass.parts.heads) return;
  second_stage_terms(pass, step);
  pass.foreground = static_cast<double>(pass.drawn.foreground.numel());
  head_terms(pass, drawn_input(pass, step), pass.drawn.objects);
}

StepLoss PvRcnnTrainee::loss(std::span<const Scene> scenes, const Step& step,
                             Communicator& processes) {
  Pass pass(parts(), objects_in_range(scenes));
  pass.count(kScans, static_cast<double>(scenes.size()));
  if (options_.keep_regions.empty()) {
    network_terms(pass, scenes, step);
  } else {
    require_heads_alone(pass.parts.first_stage || pass.parts.refinement);
    kept_terms(pass, scenes, step);
  }

  processes.sum(pass.counts);
  const auto per = [&](Count which) {
    return 1.0 / std::max(pass.counts[which].item<double>(), 1.0);
  };
  StepLoss result;
  result.total = at::zeros({}, at::kFloat);
  for (const auto& [name, term] : pass.terms) {
    const Tensor share = term.sum * (term.weight * per(term.count));
    result.total = result.total + share;
    result.terms[name] = share.item<double>();
  }
  for (const auto& [name, sum] : pass.told) result.terms[name] = sum * per(kForeground);
  result.terms["foreground"] = pass.foreground;
  return result;
}

std::map<std::string, double> PvRcnnTrainee::evaluate(const SceneSource& scenes) {
  std::map<std::string, double> result;
  const auto evaluations = pv_rcnn::evaluate_heads(network_, scenes);
  for (const auto& [head, figures] : evaluations) {
    const std::string prefix = network_->heads().size() > 1 ? head + ": " : "";
    for (const auto& [name, value] : figures) result[prefix + name] = value;
  }
  return result;
}

void PvRcnnTrainee::save(const std::filesystem::path& path) { save_model(path, *network_); }

}  // namespace arbox::training
