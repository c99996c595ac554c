#pragma once

#include <ATen/core/Tensor.h>

#include <filesystem>
#include <memory>

#include "arbox/detectors/pv_rcnn/network.h"
#include "arbox/training/scene.h"

/// \file
/// What the stages before the heads make of a scan, kept in files. Where heads alone are trained,
/// these stages are frozen and always give the same: heads learn for many epochs at the cost of
/// one.

namespace arbox::training::pv_rcnn {

/// Regions of one scan whose box is known, float32.
struct KeptRegions {
  at::Tensor features;   ///< (F, C) of SecondStage.
  at::Tensor residuals;  ///< (F, 7) of the pointwise branch.
  at::Tensor boxes;      ///< (F, 7) the regions.
  at::Tensor objects;    ///< (F, 7) the box that a head shall find for each.
};

/// The regions that a detection would ask the heads about (Options::proposals, the network in eval
/// mode) and that overlap an object of their class by an IoU of at least `least_iou`. `objects`:
/// those of the scene that are sought. Without gradient.
KeptRegions detected_regions(detectors::pv_rcnn::Network& network, const Scene& scene,
                             const std::vector<SceneObject>& objects, double least_iou);

/// Rows of several scans, one after the other; at least one part.
KeptRegions joined(const std::vector<std::shared_ptr<const KeptRegions>>& parts);

/// A .npy file of float32, (F, C + 21): features, residuals, regions, objects. Whole at any time
/// (durable_file.h). Throws IoError.
void write_kept_regions(const std::filesystem::path& file, const KeptRegions& regions);

/// Throws IoError and FormatError.
KeptRegions read_kept_regions(const std::filesystem::path& file);

/// Scenes of another source, which must outlive this one. Those whose regions are kept in the
/// folder (NUMBER.npy) come with these alone; the others come whole, with the file to keep them in.
class KeptRegionsSource : public SceneSource {
 public:
  /// Makes the folder if need be. Throws IoError.
  KeptRegionsSource(const SceneSource& scenes, std::filesystem::path folder);

  std::int64_t size() const override { return scenes_.size(); }
  Scene scene(std::int64_t index) const override;

 private:
  const SceneSource& scenes_;
  std::filesystem::path folder_;
};

}  // namespace arbox::training::pv_rcnn
