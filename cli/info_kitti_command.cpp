#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <iomanip>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include "arbox/cli/command_line.h"
#include "arbox/cli/commands.h"
#include "arbox/cli/progress.h"
#include "arbox/io/kitti_check.h"

namespace arbox::cli {
namespace {

using Json = nlohmann::ordered_json;

struct InfoKittiFlags {
  std::filesystem::path root;
  std::vector<std::string> splits;
  bool json = false;
};

constexpr std::size_t kShown = 5;

Json to_json(const io::KittiSplitReport& report) {
  Json result = {{"split", report.split}, {"folder", report.folder}, {"frames", report.frames}};
  if (!report.problem.empty()) result["problem"] = report.problem;
  result["objects"] = report.objects;
  result["files"] = Json::object();
  for (const io::KittiFileReport& files : report.files) {
    result["files"][files.kind] = {{"required", files.required},
                                   {"present", files.present},
                                   {"missing", files.missing},
                                   {"broken", files.broken}};
  }
  return result;
}

std::string first_few(const std::vector<std::string>& names) {
  std::string text;
  for (std::size_t i = 0; i < std::min(names.size(), kShown); ++i) {
    text.append(i == 0 ? "" : " ").append(names[i]);
  }
  if (names.size() > kShown) text += " and " + std::to_string(names.size() - kShown) + " more";
  return text;
}

void print_objects(const io::KittiSplitReport& report) {
  std::vector<std::pair<std::string, std::int64_t>> counts(report.objects.begin(),
                                                           report.objects.end());
  std::stable_sort(counts.begin(), counts.end(),
                   [](const auto& a, const auto& b) { return a.second > b.second; });
  for (const auto& [type, count] : counts) {
    std::cout << "  " << std::left << std::setw(16) << type << std::right << std::setw(8) << count
              << '\n';
  }
}

void print(const io::KittiSplitReport& report) {
  std::cout << report.split << ": " << report.frames << " frames in " << report.folder << '\n';
  if (!report.problem.empty()) std::cout << "  broken: " << fold_lines(report.problem) << '\n';
  if (report.frames == 0) return;
  print_objects(report);
  std::cout << "  files            present missing  broken\n";
  for (const io::KittiFileReport& files : report.files) {
    std::cout << "  " << std::left << std::setw(16) << files.kind << std::right << std::setw(8)
              << files.present << std::setw(8) << files.missing.size() << std::setw(8)
              << files.broken.size() << (files.required ? "" : "  (optional)");
    if (files.required && !files.missing.empty()) {
      std::cout << "  missing: " << first_few(files.missing);
    }
    std::cout << '\n';
  }
  for (const io::KittiFileReport& files : report.files) {
    for (std::size_t i = 0; i < std::min(files.broken.size(), kShown); ++i) {
      std::cout << "  broken: " << fold_lines(files.broken[i]) << '\n';
    }
    if (files.broken.size() > kShown) {
      std::cout << "  and " << files.broken.size() - kShown << " more broken files in "
                << files.kind << '\n';
    }
  }
}

void info_kitti(const InfoKittiFlags& flags) {
  const io::KittiDataset dataset = io::KittiDataset::open(flags.root);
  const auto splits = flags.splits.empty() ? dataset.splits() : flags.splits;
  Json result = {{"root", flags.root.string()}, {"splits", Json::array()}};
  for (const std::string& split : splits) {
    std::int64_t frames = 0;
    try {
      frames = static_cast<std::int64_t>(dataset.frames(split).size());
    } catch (const FormatError&) {
      // check_kitti_split reports it.
    }
    Progress progress("info " + split, frames);
    const io::KittiSplitReport report =
        io::check_kitti_split(dataset, split, 0, [&] { progress.advance(); });
    if (flags.json) {
      result["splits"].push_back(to_json(report));
    } else {
      print(report);
    }
  }
  if (flags.json) {
    std::cout << result.dump(2, ' ', false, Json::error_handler_t::replace) << '\n';
  }
}

}  // namespace

void add_info_kitti(CLI::App& info) {
  CLI::App* command = info.add_subcommand(
      "kitti", "Count the objects of a KITTI data set and find its missing and broken files");
  const auto flags = std::make_shared<InfoKittiFlags>();
  command->add_option("root", flags->root, "Folder with training/, testing/ and ImageSets/")
      ->required()
      ->type_name("ROOT");
  command
      ->add_option("--split", flags->splits,
                   "Only these splits, separated by commas (default: each file of ImageSets and "
                   "each whole folder)")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->type_name("NAME");
  add_json_flag(*command, flags->json);
  add_examples(*command,
               {{"arbox info kitti ~/kitti", "Each split: classes, missing and broken files"},
                {"arbox info kitti ~/kitti --split val --json",
                 "One split, with every missing frame and every broken file"}});
  command->callback([flags] { info_kitti(*flags); });
}

}  // namespace arbox::cli
