#include <CLI/CLI.hpp>
#include <algorithm>
#include <charconv>
#include <iostream>
#include <map>
#include <memory>
#include <string>

#include "arbox/cli/command_line.h"
#include "arbox/cli/commands.h"
#include "arbox/cli/standard_input.h"
#include "arbox/geometry/overlap.h"

namespace arbox::cli {
namespace {

using geometry::Box;
using geometry::Overlap;
using geometry::OverlapSpace;

const std::map<std::string, Overlap> kMeasures = {
    {"iou", Overlap::kIou}, {"iog", Overlap::kIog}, {"intersection", Overlap::kIntersection}};
const std::map<std::string, OverlapSpace> kSpaces = {{"3d", OverlapSpace::k3d},
                                                     {"bev", OverlapSpace::kBirdsEye},
                                                     {"axis-aligned", OverlapSpace::kAxisAligned}};

struct OverlapFlags {
  std::string first, second, measure, space = "3d";
  bool json = false;
};

void append_number(std::string& text, double value) {
  char digits[32];
  const auto end =
      std::to_chars(digits, digits + sizeof digits, value, std::chars_format::general, 17);
  text.append(digits, end.ptr);
}

void print_row(const double* values, std::int64_t count) {
  std::string line;
  for (std::int64_t i = 0; i < count; ++i) {
    if (i > 0) line += ',';
    append_number(line, values[i]);
  }
  std::cout << line;
}

void print_overlaps(const OverlapFlags& flags) {
  const geometry::OverlapOptions options{.measure = kMeasures.at(flags.measure),
                                         .space = kSpaces.at(flags.space)};
  if (flags.first == "-" && flags.second == "-") {
    throw UsageError("only one of --first and --second can come from standard input");
  }
  const std::vector<Box> first = read_box_table_input(flags.first).boxes;
  const std::vector<Box> second = read_box_table_input(flags.second).boxes;
  // Refuses bad rows of `first` by their number in the file, before anything is printed.
  geometry::overlap_matrix(first, {}, options);
  geometry::overlap_matrix({}, second, options);
  if (flags.json) {
    std::cout << "{\"measure\": \"" << flags.measure << "\", \"space\": \"" << flags.space
              << "\", \"overlaps\": [";
  }
  constexpr std::size_t kNumbersAtOnce = 1 << 22;
  const std::size_t rows =
      std::max<std::size_t>(1, kNumbersAtOnce / std::max<std::size_t>(1, second.size()));
  for (std::size_t begin = 0; begin < first.size(); begin += rows) {
    const auto block = std::span(first).subspan(begin, std::min(rows, first.size() - begin));
    const auto overlaps = geometry::overlap_matrix(block, second, options);
    for (Eigen::Index row = 0; row < overlaps.rows(); ++row) {
      if (flags.json) std::cout << (begin + row > 0 ? ",\n  [" : "\n  [");
      print_row(overlaps.data() + row * overlaps.cols(), overlaps.cols());
      std::cout << (flags.json ? "]" : "\n");
    }
  }
  if (flags.json) std::cout << "\n]}\n";
}

}  // namespace

void add_overlap(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "overlap",
      "Exact overlap of every box of one file with every box of another: one comma-separated row "
      "a box of the first, one number a box of the second");
  const auto flags = std::make_shared<OverlapFlags>();
  command
      ->add_option(
          "--first", flags->first,
          "Boxes, one a row: x y z l w h yaw or x y z l w h qw qx qy qz; - for standard input")
      ->type_name("CSV")
      ->required();
  command->add_option("--second", flags->second, "Boxes likewise; the ground truth of iog")
      ->type_name("CSV")
      ->required();
  command
      ->add_option("--measure", flags->measure,
                   "iou: intersection over union; iog: intersection over the second box's volume; "
                   "intersection: m^3, or m^2 with --space bev")
      ->check(CLI::IsMember({"iou", "iog", "intersection"}).description(""))
      ->type_name("iou|iog|intersection")
      ->required();
  command
      ->add_option(
          "--space", flags->space,
          "3d; bev: bases seen from above, yaw boxes only; axis-aligned: rotations ignored "
          "(default: 3d)")
      ->check(CLI::IsMember({"3d", "bev", "axis-aligned"}).description(""))
      ->type_name("3d|bev|axis-aligned");
  add_json_flag(*command, flags->json);
  add_examples(
      *command,
      {{"arbox overlap --first detections.csv --second truth.csv --measure iou", "IoU in full 3-D"},
       {"arbox overlap --first a.csv --second b.csv --measure intersection --space bev --json",
        "Areas of the bases' intersections, as JSON"}});
  command->callback([flags] { print_overlaps(*flags); });
}

}  // namespace arbox::cli
