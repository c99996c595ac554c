#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "arbox/detectors/pv_rcnn/network.h"
#include "arbox/training/augmentation.h"
#include "arbox/training/pv_rcnn/anchor_targets.h"
#include "arbox/training/pv_rcnn/losses.h"
#include "arbox/training/trainee.h"

namespace arbox::training {

/// How a PV-RCNN learns. Which parts do is said where it is trained (TrainOptions::frozen): losses
/// of frozen parts are not computed, and frozen stages run without gradient.
struct PvRcnnTraineeOptions {
  /// All of its heads learn, side by side.
  detectors::pv_rcnn::Options network;
  /// Heads learn without changing the features that they get.
  bool detach_heads = false;
  /// Where heads alone are trained: a folder that keeps what the frozen stages make of each scene
  /// (pv_rcnn/kept_regions.h), so that only the first epoch asks them. Heads then learn from the
  /// regions of a detection, from an IoU of proposals.foreground_iou on, without drawing among
  /// them; each scene stays as augmentation changed it the first time. Empty: nothing is kept.
  std::string keep_regions = {};
  pv_rcnn::ProposalTargetOptions proposals;
  /// Keypoints up to half of this outside of an object are ignored, metres.
  double keypoint_ring = 0.2;
  /// Anchors, proposals and keypoints on other objects that resemble a class (vans: cars) are
  /// neither right nor wrong, as in the KITTI benchmark's score. The reference implementation takes
  /// them for background.
  bool ignore_similar = true;
  pv_rcnn::LossOptions losses;
  AugmentationOptions augmentation;

  template <class Visitor>
  static void describe(Visitor& visitor) {
    using Self = PvRcnnTraineeOptions;
    visitor.group("network", &Self::network, "The network");
    visitor.field("detach_heads", &Self::detach_heads,
                  {.help = "Heads learn without changing the features that they get"});
    visitor.field("keep_regions", &Self::keep_regions,
                  {.help = "Folder that keeps what frozen stages make of each scene, where heads "
                           "alone are trained; epochs after the first cost next to nothing"});
    visitor.group("proposals", &Self::proposals, "What the second stage learns from");
    visitor.field("keypoint_ring", &Self::keypoint_ring,
                  {.help = "Keypoints up to half of this outside of an object are ignored",
                   .unit = "m",
                   .low = 0,
                   .high = 10});
    visitor.field("ignore_similar", &Self::ignore_similar,
                  {.help = "Take what resembles a class for neither right nor wrong, instead of "
                           "for background"});
    visitor.group("losses", &Self::losses, "Losses and their weights");
    visitor.group("augmentation", &Self::augmentation, "How scenes are changed");
  }
};

/// PV-RCNN as the trainer sees it.
class PvRcnnTrainee : public Trainee {
 public:
  /// Draws the first weights from LibTorch's generator. `objects`: scenes whose objects are pasted
  /// into others (augmentation.objects); all of them are read here. Throws ConfigError for options
  /// that are out of range or do not fit together.
  explicit PvRcnnTrainee(PvRcnnTraineeOptions options, const SceneSource* objects = nullptr);
  ~PvRcnnTrainee() override;

  torch::nn::Module& network() override { return *network_; }

  /// Augmentation, unless the scene's regions are kept.
  void prepare(Scene& scene, std::uint64_t seed, std::int64_t place) const override;

  /// Objects whose centre is outside of the network's range are left out. Terms, as they add up to
  /// the total: classification, box, direction, keypoint, confidence, residual, corner and "head
  /// NAME"; beside them the parts of each head's own loss, "NAME likelihood" and the like, as a
  /// mean over the foreground of the whole batch. Two tensors are summed over the processes: the
  /// counts.
  StepLoss loss(std::span<const Scene> scenes, const Step& step, Communicator& processes) override;

  /// AP in percent of every class: "Car 3d R40 moderate", "Car bev R40 moderate", ... (easy and
  /// hard likewise), and "Car found": the mean IoU of its objects, those harder than hard left out,
  /// with the best detection of each. With further heads names begin with the head: "gaussian: Car
  /// 3d R40 moderate". See pv_rcnn/evaluation.h for how the benchmark's protocol is applied.
  std::map<std::string, double> evaluate(const SceneSource& scenes) override;

  /// Writes the network with all its heads as a model (detectors/pv_rcnn/model.h).
  void save(const std::filesystem::path& path) override;

  const PvRcnnTraineeOptions& options() const { return options_; }
  const std::shared_ptr<detectors::pv_rcnn::Network>& detector() const { return network_; }

 private:
  /// What learns at present: parts with a parameter that requires a gradient.
  struct Parts {
    bool first_stage = false, refinement = false, heads = false;
  };
  struct Pass;
  Parts parts() const;
  pv_rcnn::SceneObjects objects_in_range(std::span<const Scene> scenes) const;
  void network_terms(Pass& pass, std::span<const Scene> scenes, const Step& step);
  void first_stage_terms(Pass& pass) const;
  void second_stage_terms(Pass& pass, const Step& step);
  void kept_terms(Pass& pass, std::span<const Scene> scenes, const Step& step);
  void head_terms(Pass& pass, const heads::HeadInput& input, const at::Tensor& targets);
  heads::HeadInput drawn_input(const Pass& pass, const Step& step) const;

  PvRcnnTraineeOptions options_;
  std::shared_ptr<detectors::pv_rcnn::Network> network_;
  std::unique_ptr<pv_rcnn::AnchorAssigner> assigner_;
  std::unique_ptr<ObjectDatabase> database_;
};

}  // namespace arbox::training
