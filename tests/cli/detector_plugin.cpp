// A plugin that brings a detector, for the tests of `arbox plugins` and `arbox config`.
#include "arbox/base/plugin.h"
#include "arbox/detectors/detector_kind.h"

namespace {

struct BlindOptions {
  int patience = 3;

  template <class Visitor>
  static void describe(Visitor& visitor) {
    visitor.field("patience", &BlindOptions::patience,
                  {.help = "How long it looks", .unit = "s", .low = 0, .high = 60});
  }
};

class BlindDetector : public arbox::detectors::Detector {
 public:
  arbox::detectors::DetectionResult detect(
      const arbox::geometry::PointCloudView&,
      const arbox::detectors::DetectionRequest&) const override {
    return {};
  }
};

void register_blind(arbox::Registrar& registrar) {
  registrar.add<arbox::detectors::DetectorKind, BlindOptions>(
      "blind", "Sees nothing",
      [](const BlindOptions&) { return std::make_unique<BlindDetector>(); });
}

}  // namespace

ARBOX_PLUGIN("detector", "blind", "0.1.0", "Apache-2.0", register_blind)
