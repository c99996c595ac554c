#include "arbox/detectors/pv_rcnn/import_openpcdet.h"

#include <algorithm>
#include <array>
#include <sstream>
#include <string_view>

#include "arbox/base/error.h"
#include "arbox/base/names.h"
#include "arbox/base/options.h"
#include "arbox/detectors/pv_rcnn/internal/name_groups.h"
#include "arbox/heads/parameters.h"
#include "arbox/io/torch_checkpoint.h"

namespace arbox::detectors::pv_rcnn {
namespace {

constexpr const char* kReferenceHead = "roi_head.autoreg.";
constexpr const char* kHead = "roi_head.box_head.autoreg.";
/// Entries that older checkpoints lack, beside which these stand.
constexpr std::string_view kBatches = "num_batches_tracked", kMean = "running_mean";

using heads::NamedTensors;
using Shape = std::vector<std::int64_t>;

/// Where each axis of (out, z, y, x, in) is found.
const std::array<std::int64_t, 5>& axes_of(SparseLayout layout) {
  static constexpr std::array<std::int64_t, 5> kSame = {0, 1, 2, 3, 4}, kFirst = {4, 0, 1, 2, 3},
                                               kNative = {3, 0, 1, 2, 4};
  if (layout == SparseLayout::kSpconv1) return kFirst;
  return layout == SparseLayout::kSpconv2Native ? kNative : kSame;
}

/// The dictionary of tensors in what was saved.
io::PickleValue state_of(const io::PickleValue& value) {
  const bool dictionary = value.is(io::PickleKind::kDict) || value.is(io::PickleKind::kObject);
  if (!dictionary) value.refuse("a dictionary with model_state");
  for (const char* key : {"model_state", "state_dict"}) {
    if (const auto state = value.find(key)) return *state;
  }
  return value;
}

NamedTensors renamed(const std::map<std::string, io::ModelRecord>& records,
                     const std::string& source) {
  constexpr std::string_view kParallel = "module.";
  const bool parallel = std::all_of(records.begin(), records.end(), [&](const auto& record) {
    return record.first.starts_with(kParallel);
  });
  NamedTensors tensors;
  for (const auto& [key, record] : records) {
    std::string name = parallel ? key.substr(kParallel.size()) : key;
    if (name == "global_step") continue;
    if (name.starts_with(kReferenceHead)) {
      name = kHead + name.substr(std::string_view(kReferenceHead).size());
    }
    tensors[name] = to_tensor(record, source + ": entry '" + key + "'");
  }
  if (tensors.empty()) {
    throw FormatError(source + ": expected a dictionary of tensors, or one under model_state");
  }
  return tensors;
}

Options network_options(const NamedTensors& tensors, const ImportOptions& options) {
  const bool autoregressive = std::any_of(
      tensors.begin(), tensors.end(), [](const auto& one) { return one.first.starts_with(kHead); });
  Options plain;
  plain.head.codec.order = "center_size_rotation";
  const Options detected = autoregressive ? autoregressive_reference_options() : plain;
  return override_options(options.network.value_or(detected), options.overrides);
}

/// Weights of sparse convolutions: five axes, here and there.
bool is_sparse_weight(const at::Tensor& own, const at::Tensor& given) {
  return own.dim() == 5 && given.dim() == 5;
}

bool fits(SparseLayout layout, const NamedTensors& own, const NamedTensors& given) {
  for (const auto& [name, tensor] : given) {
    const auto target = own.find(name);
    if (target == own.end() || !is_sparse_weight(target->second, tensor)) continue;
    if (tensor.permute(axes_of(layout)).sizes() != target->second.sizes()) return false;
  }
  return true;
}

SparseLayout layout_of(const NamedTensors& own, const NamedTensors& given, SparseLayout asked,
                       const std::string& source) {
  if (asked != SparseLayout::kAutomatic) return asked;
  std::vector<SparseLayout> fitting;
  for (const auto layout :
       {SparseLayout::kSpconv2, SparseLayout::kSpconv1, SparseLayout::kSpconv2Native}) {
    if (fits(layout, own, given)) fitting.push_back(layout);
  }
  if (fitting.size() > 1) {
    throw FormatError(source +
                      ": the shapes of the sparse convolutions fit several layouts; say which of "
                      "spconv1, spconv2 and spconv2_native it is");
  }
  return fitting.empty() ? SparseLayout::kSpconv2 : fitting.front();
}

void to_own_layout(NamedTensors& given, const NamedTensors& own, SparseLayout layout) {
  for (auto& [name, tensor] : given) {
    const auto target = own.find(name);
    if (target != own.end() && is_sparse_weight(target->second, tensor)) {
      tensor = tensor.permute(axes_of(layout)).contiguous();
    }
  }
}

/// The name as the checkpoint has it.
std::string given_name(const std::string& name) {
  if (!name.starts_with(kHead)) return name;
  return kReferenceHead + name.substr(std::string_view(kHead).size());
}

std::string shape_text(const at::Tensor& tensor) {
  std::ostringstream text;
  text << tensor.sizes();
  return text.str();
}

/// Splits the names of both sides and takes what the network has no place for out of `given`.
/// Throws if something is missing or differs.
std::vector<std::string> take_unused(NamedTensors& given, const NamedTensors& own,
                                     const std::string& source) {
  std::vector<std::string> own_names, given_names, missing, unused, differing;
  for (const auto& [name, tensor] : own) {
    own_names.push_back(given_name(name));
    const auto found = given.find(name);
    if (found == given.end()) {
      missing.push_back(own_names.back());
    } else if (found->second.sizes() != tensor.sizes()) {
      differing.push_back(own_names.back() + " " + shape_text(found->second) + ", expected " +
                          shape_text(tensor));
    }
  }
  for (const auto& [name, ignored] : given) {
    given_names.push_back(given_name(name));
    if (!own.contains(name)) unused.push_back(given_names.back());
  }
  for (auto* names : {&own_names, &given_names, &missing, &unused}) {
    std::sort(names->begin(), names->end());
  }
  unused = internal::grouped_names(unused, given_names);
  if (!missing.empty() || !differing.empty()) {
    std::vector<std::string> parts;
    const auto add = [&](const char* what, const std::vector<std::string>& names) {
      if (!names.empty()) parts.push_back(what + join(names, "; "));
    };
    add("missing: ", internal::grouped_names(missing, own_names));
    add("of another shape: ", differing);
    add("without a place in the network: ", unused);
    throw FormatError(source + ": does not fit the network of the configuration; " +
                      join(parts, "; "));
  }
  std::erase_if(given, [&](const auto& one) { return !own.contains(one.first); });
  return unused;
}

/// Counts of batches, which inference does not need, for norms whose statistics are there.
void add_missing_counts(NamedTensors& given, const NamedTensors& own) {
  for (const auto& [name, tensor] : own) {
    if (!name.ends_with(kBatches) || given.contains(name)) continue;
    const std::string norm = name.substr(0, name.size() - kBatches.size());
    if (given.contains(norm + std::string(kMean))) given[name] = tensor;
  }
}

std::string card_of(const std::filesystem::path& checkpoint, const io::PickleValue& value,
                    const Options& options) {
  std::string card = "# PV-RCNN, imported\n\nFrom the OpenPCDet checkpoint `" +
                     checkpoint.filename().string() + "`";
  if (const auto epoch = value.find("epoch"); epoch && epoch->is(io::PickleKind::kInteger)) {
    card += ", epoch " + std::to_string(epoch->integer());
  }
  if (const auto version = value.find("version"); version && version->is(io::PickleKind::kText)) {
    card += ", OpenPCDet " + std::string(version->text());
  }
  card += ". Head: " + options.head.name +
          ".\n\nIt was trained elsewhere: what it was trained on, how good it is and under which "
          "licence it may be used, its source tells. Confidence boxes need a calibration of your "
          "own.\n";
  if (options.head.name != "pointwise" && options.head.codec.order == "center_size_rotation") {
    card +=
        "\nThe head predicts centres before sizes: it cannot be asked for boxes of known "
        "sizes.\n";
  }
  return card;
}

}  // namespace

Options autoregressive_reference_options() {
  Options options;
  options.head.name = "autoregressive";
  options.head.options = {"hidden=[128, 256, 512]", "circular_ends=distinct"};
  options.head.codec.kind = "residual";
  options.head.codec.order = "center_size_rotation";
  options.head.codec.bins = 512;
  options.head.codec.size_low = options.head.codec.center_low = -0.5;
  options.head.codec.size_high = options.head.codec.center_high = 0.5;
  return options;
}

Import import_openpcdet(const std::filesystem::path& path, const ImportOptions& options) {
  const std::string source = path.string();
  const io::TorchCheckpoint checkpoint = io::read_torch_checkpoint(path);
  NamedTensors given = renamed(checkpoint.tensors(state_of(checkpoint.value())), source);
  const Options network = network_options(given, options);
  Import result{.model = {.network = std::make_shared<Network>(network)}, .report = {}};
  const NamedTensors own = heads::parameters_of(*result.model.network);
  add_missing_counts(given, own);
  result.report.layout = layout_of(own, given, options.layout, source);
  to_own_layout(given, own, result.report.layout);
  result.report.unused = take_unused(given, own, source);
  heads::load_parameters(*result.model.network, given, source);
  result.model.network->eval();
  result.report.entries = static_cast<std::int64_t>(given.size());
  for (const at::Tensor& parameter : result.model.network->parameters()) {
    result.report.parameters += parameter.numel();
  }
  result.model.notes.card = card_of(path, checkpoint.value(), network);
  return result;
}

}  // namespace arbox::detectors::pv_rcnn
