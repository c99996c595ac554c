#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <iostream>
#include <nlohmann/json.hpp>

#include "arbox/cli/command_line.h"
#include "arbox/cli/dataset_command.h"
#include "arbox/cli/option_flags.h"
#include "arbox/cli/progress.h"
#include "arbox/io/dataset_check.h"

namespace arbox::cli {
namespace {

using Json = nlohmann::ordered_json;

Json to_json(const io::DatasetCheck& check) {
  Json json = {{"layout", check.layout},     {"split", check.split},     {"scenes", check.scenes},
               {"labelled", check.labelled}, {"objects", check.objects}, {"points", check.points}};
  json["classes"] = Json::object();
  for (const auto& [name, summary] : check.classes) {
    const auto& size = summary.mean_size;
    json["classes"][name] = {{"objects", summary.objects},
                             {"without_points", summary.without_points},
                             {"mean_size", {size.x(), size.y(), size.z()}}};
  }
  json["findings"] = Json::array();
  for (const io::DatasetFinding& finding : check.findings) {
    json["findings"].push_back({{"kind", finding.kind},
                                {"text", finding.text},
                                {"mend", finding.mend},
                                {"count", finding.count},
                                {"examples", finding.examples}});
  }
  return json;
}

void print(const io::DatasetCheck& check) {
  std::printf("%s: %zu scans, %zu with labels, %zu objects, %llu points\n", check.split.c_str(),
              check.scenes, check.labelled, check.objects,
              static_cast<unsigned long long>(check.points));
  if (!check.classes.empty()) {
    std::printf("  %-20s%9s%11s   %s\n", "class", "objects", "no points", "mean size l w h (m)");
  }
  for (const auto& [name, summary] : check.classes) {
    const auto& size = summary.mean_size;
    std::printf("  %-20s%9zu%11zu   %.2f %.2f %.2f\n", name.c_str(), summary.objects,
                summary.without_points, size.x(), size.y(), size.z());
  }
  for (const io::DatasetFinding& finding : check.findings) {
    std::printf("  ! %s\n", fold_lines(finding.text).c_str());
    if (!finding.mend.empty()) std::printf("    %s\n", finding.mend.c_str());
    for (const std::string& example : finding.examples) {
      std::printf("    - %s\n", fold_lines(example).c_str());
    }
    if (finding.count > finding.examples.size() && !finding.examples.empty()) {
      std::printf("    - and %zu more\n", finding.count - finding.examples.size());
    }
  }
  if (check.findings.empty()) std::printf("  nothing wrong was found\n");
}

}  // namespace

void add_dataset_flags(CLI::App& command, io::DatasetOptions& options,
                       std::vector<std::string>& splits) {
  add_option_flags(command, bind_options(options));
  command.add_option("--split", splits, "Only these splits of a dataset, separated by commas")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->type_name("NAME");
}

void info_dataset(const DatasetInfoFlags& flags) {
  const auto dataset = io::open_dataset(flags.root, flags.options);
  const std::vector<std::string> splits =
      flags.splits.empty() ? std::vector{dataset->splits().back()} : flags.splits;
  for (const std::string& split : splits) dataset->names(split);  // Refuses what is none.
  Json result = {{"root", flags.root.string()},
                 {"layout", dataset->layout()},
                 {"frame", io::name_of(dataset->frame())},
                 {"splits", Json::object()},
                 {"checks", Json::array()}};
  for (const std::string& split : dataset->splits()) {
    result["splits"][split] = dataset->names(split).size();
  }
  if (!flags.json) {
    std::printf("%s: layout %s, frame %s\nsplits:", flags.root.c_str(),
                std::string(dataset->layout()).c_str(),
                std::string(io::name_of(dataset->frame())).c_str());
    for (const auto& [split, count] : result["splits"].items()) {
      std::printf(" %s %zu", split.c_str(), count.get<std::size_t>());
    }
    std::printf("\n");
  }
  for (const std::string& split : splits) {
    const auto scenes = static_cast<std::int64_t>(dataset->names(split).size());
    Progress progress("info " + split, scenes);
    const io::DatasetCheck check =
        io::check_dataset(*dataset, split, 0, [&] { progress.advance(); });
    if (flags.json) {
      result["checks"].push_back(to_json(check));
    } else {
      print(check);
    }
  }
  if (flags.json) {
    std::cout << result.dump(2, ' ', false, Json::error_handler_t::replace) << '\n';
  }
}

io::LabeledScene find_scene(const io::DatasetReader& dataset, const std::string& name) {
  const auto splits = dataset.splits();
  // The last split holds what is there, the others may list what is not.
  const auto all = dataset.names(splits.back());
  if (name.empty() && !all.empty()) return dataset.load(splits.back(), all.front());
  for (const std::string& split : splits) {
    const auto names = dataset.names(split);
    if (std::find(names.begin(), names.end(), name) != names.end()) {
      return dataset.load(split, name);
    }
  }
  throw UsageError("no split of the dataset holds a scene '" + name + "'");
}

}  // namespace arbox::cli
