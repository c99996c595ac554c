#include "arbox/detectors/pv_rcnn/model.h"

#include "arbox/base/error.h"
#include "arbox/base/names.h"
#include "arbox/base/options.h"

namespace arbox::detectors::pv_rcnn {
namespace {

constexpr const char* kKind = "pv_rcnn";

}  // namespace

void save_model(const std::filesystem::path& path, const Network& network, const ModelNotes& notes,
                WeightPrecision precision) {
  io::ModelArchive archive{.kind = kKind,
                           .configuration = options_yaml(network.options()),
                           .classes = network.options().classes,
                           .card = notes.card,
                           .records = records_of(network, precision)};
  if (notes.calibration) archive.calibration = evaluation::to_json(*notes.calibration);
  io::write_model_archive(path, archive, precision == WeightPrecision::kHalf);
}

Model to_model(const io::ModelArchive& archive, const std::string& source,
               const std::vector<std::string>& overrides) {
  if (archive.kind != kKind) {
    throw FormatError(source + ": expected a model of kind " + kKind + ", got '" + archive.kind +
                      "'");
  }
  const auto options = parse_options<Options>(archive.configuration, source + ": configuration");
  if (options.classes != archive.classes) {
    throw FormatError(source + ": expected the classes of the configuration (" +
                      join(options.classes, ", ") + "), got " + join(archive.classes, ", "));
  }
  Model model{.network = std::make_shared<Network>(override_options(options, overrides)),
              .notes = {.card = archive.card}};
  if (!archive.calibration.empty()) {
    model.notes.calibration = evaluation::parse_confidence_calibration(
        archive.calibration, source + ": calibration.json");
  }
  load_records(*model.network, archive.records, source);
  model.network->eval();
  return model;
}

Model load_model(const std::filesystem::path& path, const std::vector<std::string>& overrides) {
  return to_model(io::read_model_archive(path), path.string(), overrides);
}

std::unique_ptr<PvRcnn> load_pv_rcnn(const std::filesystem::path& path,
                                     const std::vector<std::string>& overrides) {
  Model model = load_model(path, overrides);
  return std::make_unique<PvRcnn>(std::move(model.network), std::move(model.notes.calibration));
}

}  // namespace arbox::detectors::pv_rcnn
