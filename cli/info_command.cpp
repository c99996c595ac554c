#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "arbox/cli/command_line.h"
#include "arbox/cli/commands.h"
#include "arbox/cli/dataset_command.h"
#include "arbox/cli/model_info.h"
#include "arbox/cli/option_flags.h"
#include "arbox/cli/standard_input.h"
#include "arbox/io/model_search.h"

namespace arbox::cli {
namespace {

using Json = nlohmann::ordered_json;

struct InfoFlags {
  std::string path;
  // The file's own numbers are told.
  io::ReadOptions read{.scale_intensity = false};
  io::DatasetOptions dataset;
  std::vector<std::string> splits;
  bool json = false;
};

struct Range {
  std::string name;
  double low = std::numeric_limits<double>::infinity();
  double high = -std::numeric_limits<double>::infinity();
  double sum = 0.0;
  std::size_t count = 0;

  void add(double value) {
    if (!std::isfinite(value)) return;
    low = std::min(low, value);
    high = std::max(high, value);
    sum += value;
    ++count;
  }
};

// Of x, y, z and every channel, over finite numbers.
std::vector<Range> ranges_of(const geometry::PointCloud& points) {
  std::vector<Range> ranges;
  for (const char* axis : {"x", "y", "z"}) ranges.push_back({.name = axis});
  for (const std::string& channel : points.channels) ranges.push_back({.name = channel});
  for (std::size_t i = 0; i < points.values.size(); ++i) {
    ranges[i % ranges.size()].add(points.values[i]);
  }
  return ranges;
}

Json to_json(const std::string& path, const io::PointCloudFile& file) {
  const std::vector<Range> ranges = ranges_of(file.points);
  Json channels = Json::object();
  Json low = Json::array(), high = Json::array();
  for (const Range& range : ranges) {
    const bool known = range.count > 0;
    const Json least = known ? Json(range.low) : Json();
    const Json most = known ? Json(range.high) : Json();
    if (low.size() < 3) {
      low.push_back(least);
      high.push_back(most);
    }
    channels[range.name] = {
        {"min", least},
        {"max", most},
        {"mean", known ? Json(range.sum / static_cast<double>(range.count)) : Json()}};
  }
  Json json{{"file", path},
            {"format", io::name_of(file.format)},
            {"encoding", file.encoding},
            {"points", file.points_in_file},
            {"width", file.width},
            {"height", file.height},
            {"non_finite", file.non_finite},
            {"bounds", {{"min", low}, {"max", high}}},
            {"channels", channels}};
  if (file.format == io::PointCloudFormat::kPcd) json["viewpoint"] = file.viewpoint;
  if (file.time_origin != 0.0) json["time_origin"] = file.time_origin;
  if (file.unused_bytes > 0) json["unused_bytes"] = file.unused_bytes;
  return json;
}

void print_table(const std::string& path, const io::PointCloudFile& file) {
  const auto row = [](const char* name, const std::string& value) {
    std::printf("%-12s%s\n", name, value.c_str());
  };
  row("file", path);
  row("format", std::string(io::name_of(file.format)) + " (" + file.encoding + ")");
  row("points", std::to_string(file.points_in_file));
  if (file.height > 1) {
    row("image", std::to_string(file.width) + " x " + std::to_string(file.height));
  }
  row("non-finite", std::to_string(file.non_finite));
  if (file.unused_bytes > 0) row("unused", std::to_string(file.unused_bytes) + " bytes at the end");
  std::printf("\n%-14s%14s%14s%14s\n", "channel", "min", "max", "mean");
  for (const Range& range : ranges_of(file.points)) {
    if (range.count == 0) {
      std::printf("%-14s%14s%14s%14s\n", range.name.c_str(), "-", "-", "-");
      continue;
    }
    std::printf("%-14s%14.6g%14.6g%14.6g\n", range.name.c_str(), range.low, range.high,
                range.sum / static_cast<double>(range.count));
  }
}

/// An installed model of that name, unless something else is called so.
std::optional<std::filesystem::path> installed_model(const std::string& name) {
  std::error_code ignored;
  if (std::filesystem::exists(name, ignored)) return std::nullopt;
  for (const std::filesystem::path& folder : io::model_folders()) {
    const std::filesystem::path file = folder / (name + ".arbox");
    if (std::filesystem::exists(file, ignored)) return file;
  }
  return std::nullopt;
}

void info(const InfoFlags& flags) {
  if (flags.path.empty()) throw UsageError("info: expected a file, a folder or a subcommand");
  std::error_code ignored;
  if (std::filesystem::is_directory(flags.path, ignored)) {
    info_dataset({flags.path, flags.dataset, flags.splits, flags.json});
    return;
  }
  if (const auto model = installed_model(flags.path)) {
    print_model(model->string(), flags.json);
    return;
  }
  if (is_model_file(flags.path)) {
    print_model(flags.path, flags.json);
    return;
  }
  const io::PointCloudFile file = read_point_cloud_input(flags.path, flags.read);
  if (flags.json) {
    std::cout << to_json(flags.path, file).dump(2) << '\n';
  } else {
    print_table(flags.path, file);
  }
}

}  // namespace

void add_info(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "info",
      "What a point-cloud file, a model or a dataset holds, and what is wrong with a dataset's "
      "labels");
  const auto flags = std::make_shared<InfoFlags>();
  command
      ->add_option("file", flags->path,
                   "Point cloud (- for standard input), model (a file, or the name of an "
                   "installed one) or folder of a dataset")
      ->type_name("FILE|DATASET");
  add_option_flags(*command, bind_options(flags->read), {"keep_non_finite", "scale_intensity"});
  add_dataset_flags(*command, flags->dataset, flags->splits);
  add_json_flag(*command, flags->json);
  add_examples(*command,
               {{"arbox info scan.pcd", "Its format, points, channels and bounds"},
                {"arbox info nuscenes.pcd.bin --channels 5 --json", "A .bin of five columns"},
                {"arbox info rooms.npz --array pc", "One array of an archive"},
                {"arbox info car.arbox", "A model: classes, configuration, calibration"},
                {"arbox info pv_rcnn_compact", "The same of the model that comes with Arbox"},
                {"arbox info my_data", "A dataset: classes, sizes, and mistakes in its labels"},
                {"arbox info kitti ROOT", "A KITTI folder: counts, missing and broken files"}});
  add_info_kitti(*command);
  command->callback([command, flags] {
    if (command->get_subcommands().empty()) info(*flags);
  });
}

}  // namespace arbox::cli
