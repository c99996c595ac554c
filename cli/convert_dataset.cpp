#include <spdlog/spdlog.h>
#include <CLI/CLI.hpp>
#include <algorithm>
#include <atomic>
#include <iostream>
#include <map>
#include <mutex>
#include <nlohmann/json.hpp>
#include <set>

#include "arbox/base/parallel.h"
#include "arbox/cli/command_line.h"
#include "arbox/cli/dataset_command.h"
#include "arbox/cli/progress.h"

namespace arbox::cli {
namespace {

using Json = nlohmann::ordered_json;

std::map<std::string, std::string> read_class_map(const std::vector<std::string>& entries) {
  std::map<std::string, std::string> result;
  for (const std::string& entry : entries) {
    const std::size_t equals = entry.find('=');
    if (equals == std::string::npos || equals == 0) {
      throw UsageError("--class-map " + entry + ": expected FROM=TO");
    }
    result[entry.substr(0, equals)] = entry.substr(equals + 1);
  }
  return result;
}

struct Job {
  std::string split, name;
};

/// Each scene once, in the first split that lists it; the last split, which holds all, only fills
/// up.
std::vector<Job> plan(const io::DatasetReader& dataset, const std::vector<std::string>& wanted) {
  const auto splits = wanted.empty() ? dataset.splits() : wanted;
  std::vector<Job> jobs;
  std::set<std::string> seen;
  for (const std::string& split : splits) {
    // What holds everything is no split of its own where there are others.
    if (wanted.empty() && splits.size() > 1 && split == splits.back()) continue;
    for (const std::string& name : dataset.names(split)) {
      if (seen.insert(name).second) jobs.push_back({split, name});
    }
  }
  return jobs;
}

void rename_classes(io::LabeledScene& scene, const std::map<std::string, std::string>& map) {
  std::vector<io::LabeledObject> kept;
  std::vector<std::int32_t> index(scene.objects.size(), -1);
  for (std::size_t i = 0; i < scene.objects.size(); ++i) {
    const auto found = map.find(scene.objects[i].label);
    if (found != map.end()) scene.objects[i].label = found->second;
    if (scene.objects[i].label.empty() && found != map.end()) continue;
    index[i] = static_cast<std::int32_t>(kept.size());
    kept.push_back(std::move(scene.objects[i]));
  }
  for (std::int32_t& object : scene.point_objects) {
    if (object >= 0) object = index[object];
  }
  if (scene.images && kept.size() != index.size()) {
    for (auto* masks : {&scene.images->visible_masks, &scene.images->amodal_masks}) {
      std::vector<std::vector<std::uint8_t>> left;
      for (std::size_t i = 0; i < masks->size(); ++i) {
        if (index[i] >= 0) left.push_back(std::move((*masks)[i]));
      }
      *masks = std::move(left);
    }
  }
  scene.objects = std::move(kept);
}

void give(const io::WriteReport& report, const DatasetConvertFlags& flags, std::size_t broken) {
  if (flags.json) {
    Json json = {{"input", flags.input.string()}, {"output", flags.output.string()},
                 {"layout", flags.layout},        {"scenes", report.scenes},
                 {"objects", report.objects},     {"enclosed", report.enclosed},
                 {"left_out", Json::object()},    {"broken", broken}};
    for (const auto& [label, count] : report.left_out) json["left_out"][label] = count;
    json["notes"] = Json::object();
    for (const auto& [what, count] : report.notes) json["notes"][what] = count;
    std::cout << json.dump(2, ' ', false, Json::error_handler_t::replace) << '\n';
    return;
  }
  std::cout << flags.output.string() << ": " << report.scenes << " scenes, " << report.objects
            << " objects in layout " << flags.layout << '\n';
  for (const auto& [label, count] : report.left_out) {
    spdlog::warn(
        "{} objects of class {} were left out: layout {} has no number for it "
        "(--class-map {}=CLASS gives it one)",
        count, label, flags.layout, label);
  }
  if (report.enclosed > 0) {
    spdlog::warn("{} boxes were replaced by ones around them that layout {} can hold",
                 report.enclosed, flags.layout);
  }
  for (const auto& [what, count] : report.notes) spdlog::warn("{} {}", count, what);
  if (broken > 0) spdlog::warn("{} scenes could not be read and were passed over", broken);
}

}  // namespace

void convert_dataset(const DatasetConvertFlags& flags) {
  const auto map = read_class_map(flags.class_map);
  const auto layouts = io::dataset_layouts();
  if (std::find(layouts.begin(), layouts.end(), flags.layout) == layouts.end()) {
    std::string known;
    for (const auto& name : layouts) known += (known.empty() ? "" : ", ") + name;
    throw UsageError("--to-layout " + flags.layout + ": expected one of " + known);
  }
  const auto dataset = io::open_dataset(flags.input, flags.options);
  const auto jobs = plan(*dataset, flags.splits);
  const auto writer = io::create_dataset(
      flags.output, flags.layout, dataset->frame(),
      map.empty() ? dataset->classes() : std::vector<std::string>{}, flags.write);
  std::atomic<std::size_t> broken = 0;
  Progress progress("convert", static_cast<std::int64_t>(jobs.size()));
  parallel_for(static_cast<std::int64_t>(jobs.size()), 1, 0,
               [&](std::int64_t begin, std::int64_t end) {
                 for (std::int64_t i = begin; i < end; ++i) {
                   const Job& job = jobs[static_cast<std::size_t>(i)];
                   std::optional<io::LabeledScene> scene;
                   try {
                     scene = dataset->load(job.split, job.name);
                   } catch (const Error&) {
                     if (!flags.skip_broken) throw;
                     ++broken;
                   }
                   if (scene) {
                     rename_classes(*scene, map);
                     writer->add(job.split, *scene);
                   }
                   progress.advance();
                 }
               });
  give(writer->finish(), flags, broken);
}

}  // namespace arbox::cli
