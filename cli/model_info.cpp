#include "arbox/cli/model_info.h"

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <sstream>

#include "arbox/base/names.h"
#include "arbox/evaluation/confidence_calibration.h"
#include "arbox/io/file.h"
#include "arbox/io/model_archive.h"

namespace arbox::cli {
namespace {

using Json = nlohmann::ordered_json;
using evaluation::ConfidenceCalibration;

/// Numbers of a network that are counted, not learnt.
bool is_statistic(std::string_view name) {
  return name.ends_with("running_mean") || name.ends_with("running_var") ||
         name.ends_with("num_batches_tracked");
}

struct Totals {
  std::size_t parameters = 0, statistics = 0, bytes = 0;
  std::map<std::string, std::size_t> types;
};

Totals totals_of(const io::ModelArchive& archive) {
  Totals totals;
  for (const auto& [name, record] : archive.records) {
    (is_statistic(name) ? totals.statistics : totals.parameters) += record.count();
    totals.bytes += record.data.size();
    ++totals.types[std::string(io::name_of(record.type))];
  }
  return totals;
}

/// The largest probability that a class's objects are enough for.
double highest_promise(const ConfidenceCalibration& calibration, const std::string& label) {
  std::int64_t contained = 0;
  for (const auto& extent : calibration.classes.at(label)) {
    if (std::isfinite(extent.extent)) contained += extent.count;
  }
  return static_cast<double>(contained) / static_cast<double>(calibration.objects(label) + 1);
}

Json summary_of(const ConfidenceCalibration& calibration) {
  Json classes = Json::object();
  for (const auto& [label, ignored] : calibration.classes) {
    classes[label] = {{"objects", calibration.objects(label)},
                      {"highest_probability", highest_promise(calibration, label)}};
  }
  return {{"source", calibration.source}, {"min_iog", calibration.min_iog}, {"classes", classes}};
}

Json json_of(const std::string& path, const io::ModelArchive& archive,
             const std::optional<ConfidenceCalibration>& calibration) {
  const Totals totals = totals_of(archive);
  return {{"file", path},
          {"kind", archive.kind},
          {"classes", archive.classes},
          {"parameters", totals.parameters},
          {"statistics", totals.statistics},
          {"bytes", totals.bytes},
          {"records", totals.types},
          {"calibration", calibration ? summary_of(*calibration) : Json()},
          {"configuration", archive.configuration},
          {"card", archive.card}};
}

void print_row(const char* name, const std::string& value) {
  std::printf("%-14s%s\n", name, value.c_str());
}

void print_calibration(const std::optional<ConfidenceCalibration>& calibration) {
  if (!calibration) {
    print_row("calibration", "none: confidence boxes cannot be asked for");
    return;
  }
  print_row("calibration", calibration->source);
  std::printf(
      "  A confidence box of probability p contains more than %g %% of the object with "
      "probability\n"
      "  p: on average over the objects of a class that this model finds in scans like those of "
      "the\n"
      "  calibration (sensor, places, weather). For other scans nothing is promised.\n",
      100 * calibration->min_iog);
  for (const auto& [label, ignored] : calibration->classes) {
    std::printf("  %-20s%8lld objects, p up to %.4g\n", label.c_str(),
                static_cast<long long>(calibration->objects(label)),
                highest_promise(*calibration, label));
  }
}

/// Without the lines that explain the keys.
void print_configuration(const std::string& yaml) {
  std::istringstream lines(yaml);
  for (std::string line; std::getline(lines, line);) {
    const std::size_t first = line.find_first_not_of(' ');
    if (first != std::string::npos && line[first] != '#') std::printf("  %s\n", line.c_str());
  }
}

void print_table(const std::string& path, const io::ModelArchive& archive,
                 const std::optional<ConfidenceCalibration>& calibration) {
  const Totals totals = totals_of(archive);
  print_row("file", path);
  print_row("model", archive.kind);
  print_row("classes", archive.classes.empty() ? "none" : join(archive.classes, ", "));
  std::vector<std::string> types;
  for (const auto& [type, count] : totals.types)
    types.push_back(std::to_string(count) + " " + type);
  print_row("parameters", std::to_string(totals.parameters) + ", and " +
                              std::to_string(totals.statistics) + " statistics");
  print_row("arrays", (types.empty() ? "none" : join(types, ", ")) + "; " +
                          std::to_string(totals.bytes) + " bytes");
  print_calibration(calibration);
  if (!archive.card.empty()) std::printf("\n%s", archive.card.c_str());
  std::printf("\nconfiguration\n");
  print_configuration(archive.configuration);
}

}  // namespace

bool is_model_file(const std::string& path) {
  constexpr std::size_t kEnough = 64;
  std::error_code error;
  return std::filesystem::is_regular_file(path, error) &&
         io::is_model_archive(io::read_file(path, kEnough));
}

void print_model(const std::string& path, bool json) {
  const io::ModelArchive archive = io::read_model_archive(path);
  std::optional<ConfidenceCalibration> calibration;
  if (!archive.calibration.empty()) {
    calibration =
        evaluation::parse_confidence_calibration(archive.calibration, path + ": calibration.json");
  }
  if (json) {
    std::cout
        << json_of(path, archive, calibration).dump(2, ' ', false, Json::error_handler_t::replace)
        << '\n';
  } else {
    print_table(path, archive, calibration);
  }
}

}  // namespace arbox::cli
