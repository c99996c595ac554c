#include "arbox/detectors/pv_rcnn/model.h"

#include "arbox/base/error.h"
#include "arbox/base/names.h"
#include "arbox/base/options.h"

namespace arbox::detectors::pv_rcnn {
namespace {

constexpr const char* kKind = "pv_rcnn";
constexpr const char* kHeadGroup = "roi_head.box_head.";
constexpr const char* kFurtherHeads = "box_heads.";

}  // namespace

io::ModelArchive to_archive(const Network& network, const heads::BoxHead& head,
                            const Options& options, const ModelNotes& notes,
                            WeightPrecision precision) {
  io::ModelArchive archive{.kind = kKind,
                           .configuration = options_yaml(options),
                           .classes = options.classes,
                           .card = notes.card};
  if (notes.calibration) archive.calibration = evaluation::to_json(*notes.calibration);
  archive.records = records_of(network, precision);
  std::erase_if(archive.records, [](const auto& record) {
    return record.first.starts_with(kHeadGroup) || record.first.starts_with(kFurtherHeads);
  });
  for (auto& [name, record] : records_of(head, precision)) {
    archive.records[kHeadGroup + name] = std::move(record);
  }
  return archive;
}

void save_model(const std::filesystem::path& path, Network& network, const ModelNotes& notes,
                WeightPrecision precision) {
  io::write_model_archive(path,
                          to_archive(network, network.head(), network.options(), notes, precision));
}

Model to_model(const io::ModelArchive& archive, const std::string& source) {
  if (archive.kind != kKind) {
    throw FormatError(source + ": expected a model of kind " + kKind + ", got '" + archive.kind +
                      "'");
  }
  const auto options = parse_options<Options>(archive.configuration, source + ": configuration");
  if (options.classes != archive.classes) {
    throw FormatError(source + ": expected the classes of the configuration (" +
                      join(options.classes, ", ") + "), got " + join(archive.classes, ", "));
  }
  Model model{.network = std::make_shared<Network>(options), .notes = {.card = archive.card}};
  if (!archive.calibration.empty()) {
    model.notes.calibration = evaluation::parse_confidence_calibration(
        archive.calibration, source + ": calibration.json");
  }
  load_records(*model.network, archive.records, source);
  model.network->eval();
  return model;
}

Model load_model(const std::filesystem::path& path) {
  return to_model(io::read_model_archive(path), path.string());
}

std::unique_ptr<PvRcnn> load_pv_rcnn(const std::filesystem::path& path) {
  Model model = load_model(path);
  return std::make_unique<PvRcnn>(std::move(model.network), std::move(model.notes.calibration));
}

}  // namespace arbox::detectors::pv_rcnn
