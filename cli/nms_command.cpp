#include <CLI/CLI.hpp>
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
#include "arbox/geometry/nms.h"
#include "arbox/io/box_table.h"

namespace arbox::cli {
namespace {

struct NmsFlags {
  std::string input;
  geometry::NmsOptions options;
  bool json = false;
};

std::vector<int> numbers_of(const std::vector<std::string>& names) {
  std::map<std::string, int> number;
  std::vector<int> result;
  for (const std::string& name : names) {
    result.push_back(number.emplace(name, static_cast<int>(number.size())).first->second);
  }
  return result;
}

io::BoxTable rows_of(const io::BoxTable& table, const geometry::NmsResult& result) {
  io::BoxTable kept;
  for (std::size_t i = 0; i < result.kept.size(); ++i) {
    const std::int64_t row = result.kept[i];
    kept.boxes.push_back(table.boxes[row]);
    kept.scores.push_back(result.scores[i]);
    if (!table.objects.empty()) kept.objects.push_back(table.objects[row]);
    if (!table.classes.empty()) kept.classes.push_back(table.classes[row]);
  }
  return kept;
}

void print_kept(const NmsFlags& flags) {
  const io::BoxTable table =
      read_box_table_input(flags.input, {.score = true, .class_name = flags.options.class_aware});
  if (!table.boxes.empty() && table.scores.empty()) {
    throw FormatError(flags.input +
                      ": expected a column score, found none; name it in a header "
                      "or put it behind the box");
  }
  if (!table.boxes.empty() && flags.options.class_aware && table.classes.empty()) {
    throw FormatError(flags.input + ": --class-aware needs a column class, found none");
  }
  const auto result =
      geometry::nms(table.boxes, table.scores, flags.options, numbers_of(table.classes));
  if (flags.json) {
    std::cout << nlohmann::ordered_json{{"kept", result.kept}, {"scores", result.scores}} << '\n';
  } else {
    std::cout << io::format_box_table(rows_of(table, result));
  }
}

}  // namespace

void add_nms(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "nms",
      "Non-maximum suppression: of the boxes of a file that overlap, prints the rows with the best "
      "scores, best first");
  const auto flags = std::make_shared<NmsFlags>();
  command
      ->add_option("input", flags->input,
                   "Boxes with a column score and, if need be, class: x y z l w h yaw score class, "
                   "the four numbers of a quaternion in place of yaw, or any order under a header; "
                   "- for standard input")
      ->type_name("CSV")
      ->required();
  add_option_flags(*command, bind_options(flags->options), {"threads"});
  command->add_flag("--json", flags->json,
                    "Print the numbers of the rows kept, from 0, and their scores as JSON");
  add_examples(*command,
               {{"arbox nms proposals.csv --threshold 0.1", "From above, as most car detectors do"},
                {"arbox nms proposals.csv --class-aware --space 3d", "In full 3-D, class by class"},
                {"arbox nms proposals.csv --soft gaussian --minimum-score 0.05",
                 "Soft-NMS: scores sink in place of rows that go"}});
  command->callback([flags] { print_kept(*flags); });
}

}  // namespace arbox::cli
