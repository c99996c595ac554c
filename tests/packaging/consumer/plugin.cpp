#include <arbox/base/plugin.h>
#include <arbox/detectors/detector_kind.h>

namespace {

struct NothingOptions {
  template <class Visitor>
  static void describe(Visitor&) {}
};

class Nothing : public arbox::detectors::Detector {
 public:
  arbox::detectors::DetectionResult detect(
      const arbox::geometry::PointCloudView&,
      const arbox::detectors::DetectionRequest&) const override {
    return {};
  }
};

void register_nothing(arbox::Registrar& registrar) {
  registrar.add<arbox::detectors::DetectorKind, NothingOptions>(
      "nothing", "Finds nothing",
      [](const NothingOptions&) { return std::make_unique<Nothing>(); });
}

}  // namespace

ARBOX_PLUGIN("detector", "nothing", "1.0.0", "MIT", register_nothing)
