#include <CLI/CLI.hpp>
#include <cstdint>
#include <iostream>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "arbox/cli/command_line.h"
#include "arbox/cli/commands.h"
#include "arbox/cli/option_flags.h"
#include "arbox/cli/standard_input.h"
#include "arbox/geometry/quantile_box.h"
#include "arbox/io/detection_json.h"
#include "arbox/io/file.h"

namespace arbox::cli {
namespace {

using geometry::Box;
using geometry::QuantileBox;
using Json = nlohmann::ordered_json;

struct QuantileFlags {
  std::string samples, json, csv;
  std::vector<double> quantiles;
  std::vector<double> uncertainty = {0.2, 0.8};
  geometry::QuantileOptions options;
};

struct ObjectResult {
  std::int64_t object;
  std::vector<QuantileBox> boxes;
  double uncertainty;
};

/// In ascending order of the objects' numbers; samples keep the order of their rows.
std::map<std::int64_t, std::vector<Box>> grouped(const io::BoxTable& table) {
  std::map<std::int64_t, std::vector<Box>> objects;
  for (std::size_t row = 0; row < table.boxes.size(); ++row) {
    objects[table.objects.empty() ? 0 : table.objects[row]].push_back(table.boxes[row]);
  }
  return objects;
}

std::vector<ObjectResult> compute(const QuantileFlags& flags) {
  const auto objects = grouped(read_box_table_input(flags.samples, {.object = true}));
  std::vector<geometry::BoxSamples> samples;
  for (const auto& [object, boxes] : objects) {
    samples.push_back({.boxes = boxes, .object = static_cast<std::uint64_t>(object)});
  }
  // The last two are for the uncertainty.
  std::vector<double> qs = flags.quantiles;
  qs.insert(qs.end(), flags.uncertainty.begin(), flags.uncertainty.end());
  auto boxes = geometry::quantile_boxes(samples, qs, flags.options);
  std::vector<ObjectResult> results;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const std::size_t asked = flags.quantiles.size();
    const double uncertainty =
        geometry::quantile_uncertainty(boxes[i][asked].box, boxes[i][asked + 1].box);
    boxes[i].resize(asked);
    results.push_back(
        {static_cast<std::int64_t>(samples[i].object), std::move(boxes[i]), uncertainty});
  }
  return results;
}

std::string to_json(const std::vector<ObjectResult>& results) {
  Json objects = Json::array();
  for (const ObjectResult& result : results) {
    Json boxes = Json::array();
    for (const QuantileBox& quantile : result.boxes) {
      boxes.push_back({{"q", quantile.q},
                       {"box", Json::parse(io::format_box_json(quantile.box))},
                       {"fallback", quantile.fallback}});
    }
    objects.push_back({{"object", result.object},
                       {"quantile_boxes", std::move(boxes)},
                       {"uncertainty", result.uncertainty}});
  }
  return Json{{"objects", std::move(objects)}}.dump() + '\n';
}

std::string to_rows(const std::vector<ObjectResult>& results) {
  std::string text = "object,q,fallback,uncertainty,x,y,z,l,w,h,qw,qx,qy,qz\n";
  for (const ObjectResult& result : results) {
    for (const QuantileBox& quantile : result.boxes) {
      const Box& box = quantile.box;
      const auto& r = box.rotation;
      text += std::to_string(result.object) + ',' + Json(quantile.q).dump() +
              (quantile.fallback ? ",1" : ",0");
      for (const double value :
           {result.uncertainty, box.center.x(), box.center.y(), box.center.z(), box.size.x(),
            box.size.y(), box.size.z(), r.w(), r.x(), r.y(), r.z()}) {
        text += ',' + Json(value).dump();
      }
      text += '\n';
    }
  }
  return text;
}

void give(const std::string& text, const std::string& file) {
  if (file == "-") {
    std::cout << text;
  } else {
    io::write_file(file, text);
  }
}

void give_quantile_boxes(const QuantileFlags& flags) {
  const auto results = compute(flags);
  if (!flags.csv.empty()) give(to_rows(results), flags.csv);
  if (!flags.json.empty()) give(to_json(results), flags.json);
  if (flags.csv.empty() && flags.json.empty()) give(to_json(results), "-");
}

}  // namespace

void add_quantile_box(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "quantile-box",
      "The boxes that hold what the samples of an object's box agree on: for each quantile the "
      "smallest box around the points that more than that part of the samples hold");
  const auto flags = std::make_shared<QuantileFlags>();
  command
      ->add_option("--samples", flags->samples,
                   "Box samples, one a row: x y z l w h yaw or x y z l w h qw qx qy qz, with an "
                   "optional first column object that groups them; - for standard input")
      ->type_name("CSV")
      ->required();
  command->add_option("--quantile", flags->quantiles, "Quantiles: 0.1 gives the box for p = 0.9")
      ->check(CLI::Range(0.0, 1.0).description(""))
      ->type_name("Q...")
      ->required();
  command
      ->add_option("--uncertainty", flags->uncertainty,
                   "The two quantiles whose boxes give the uncertainty 1 - IoU (default: 0.2 0.8)")
      ->check(CLI::Range(0.0, 1.0).description(""))
      ->expected(2)
      ->type_name("A B");
  command
      ->add_option("--json", flags->json, "Write the JSON to this file (default: standard output)")
      ->type_name("FILE");
  command
      ->add_option("--csv", flags->csv,
                   "Write rows of CSV to this file, - for standard output; JSON only if asked for")
      ->type_name("FILE");
  add_option_flags(*command, bind_options(flags->options), {"threads"});
  add_examples(
      *command,
      {{"arbox quantile-box --samples ensemble.csv --quantile 0.1 0.5",
        "Two boxes of each object, as JSON: one nearly sure to hold it, and what half agree on"},
       {"arbox quantile-box --samples draws.csv --quantile 0.2 --json boxes.json", "Into a file"},
       {"arbox quantile-box --samples draws.csv --quantile 0.2 --csv -", "As rows of CSV"}});
  command->callback([flags] { give_quantile_boxes(*flags); });
}

}  // namespace arbox::cli
