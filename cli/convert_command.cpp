#include <CLI/CLI.hpp>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include "arbox/cli/command_line.h"
#include "arbox/cli/commands.h"
#include "arbox/cli/dataset_command.h"
#include "arbox/cli/option_flags.h"
#include "arbox/cli/standard_input.h"

namespace arbox::cli {
namespace {

struct ConvertFlags {
  std::string input, output;
  // The file's own intensities are kept unless asked.
  io::ReadOptions read{.scale_intensity = false};
  io::WriteOptions write;
  DatasetConvertFlags dataset;
  bool json = false;
};

io::PointCloudFormat output_format(const ConvertFlags& flags) {
  const std::string word = flags.write.format.empty() ? "" : "." + flags.write.format;
  const auto format = io::format_of_extension(flags.write.format == "text" ? "a.txt"
                                              : word.empty()               ? flags.output
                                                                           : "a" + word);
  if (format) return *format;
  throw UsageError("convert: '" + flags.output +
                   "' names no format (.pcd, .ply, .bin, .npy, .npz, .csv); say which with --to");
}

void convert(const ConvertFlags& flags) {
  std::error_code ignored;
  if (std::filesystem::is_directory(flags.input, ignored)) {
    DatasetConvertFlags dataset = flags.dataset;
    dataset.input = flags.input;
    dataset.output = flags.output;
    dataset.json = flags.json;
    convert_dataset(dataset);
    return;
  }
  const io::PointCloudFormat format = output_format(flags);
  if (flags.json && flags.output == "-") {
    throw UsageError("convert: --json and the output - both need standard output");
  }
  const io::PointCloudFile file = read_point_cloud_input(flags.input, flags.read);
  if (flags.output == "-") {
    std::cout << io::encode_point_cloud(file.points.view(), format, flags.write) << std::flush;
    if (!std::cout) throw IoError("standard output: cannot be written");
  } else {
    io::write_point_cloud(flags.output, file.points.view(), flags.write);
  }
  if (flags.json) {
    std::cout << nlohmann::ordered_json{{"input", flags.input},
                                        {"output", flags.output},
                                        {"format", io::name_of(format)},
                                        {"points", file.points.size()},
                                        {"non_finite", file.non_finite},
                                        {"dropped", file.dropped}}
                     .dump(2)
              << '\n';
  } else if (file.dropped > 0) {
    std::cerr << "arbox: dropped " << file.dropped << " of " << file.points_in_file
              << " points with coordinates that are not finite (--keep-non-finite keeps them)\n";
  }
}

}  // namespace

void add_convert(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "convert", "Turn a point-cloud file into another format, or a dataset into another layout");
  const auto flags = std::make_shared<ConvertFlags>();
  const auto formats = CLI::IsMember({"pcd", "ply", "bin", "npy", "npz", "text"});
  command
      ->add_option("input", flags->input,
                   "Point cloud (- for standard input) or folder of a dataset")
      ->type_name("IN")
      ->required();
  command
      ->add_option("output", flags->output, "File (- for standard output) or new folder to write")
      ->type_name("OUT")
      ->required();
  add_option_flags(*command, bind_options(flags->read), {"format"});
  command->add_option("--from", flags->read.format, "Format of the input")->check(formats);
  command->add_option("--to", flags->write.format, "Format of the output")->check(formats);
  command->add_option("--encoding", flags->write.encoding, "Encoding of PCD and PLY")
      ->check(CLI::IsMember({"ascii", "binary", "binary_compressed"}));
  command
      ->add_option("--write-channels", flags->write.channels,
                   "Channels to write after x, y, z (default: all; .bin: intensity)")
      ->delimiter(',');
  DatasetConvertFlags& dataset = flags->dataset;
  add_dataset_flags(*command, dataset.options, dataset.splits);
  command->add_option("--to-layout", dataset.layout, "Layout of the dataset that is written")
      ->check(CLI::IsMember(io::dataset_layouts()))
      ->capture_default_str();
  add_option_flags(*command, bind_options(dataset.write));
  command
      ->add_option("--class-map", dataset.class_map,
                   "Rename a class of the dataset; FROM= leaves it out")
      ->type_name("FROM=TO");
  command->add_flag("--skip-broken", dataset.skip_broken,
                    "Pass over scenes that cannot be read (default: stop at the first)");
  add_json_flag(*command, flags->json);
  add_examples(
      *command,
      {{"arbox convert kitti my_data --split train,val", "A dataset in Arbox' own layout"},
       {"arbox convert my_data out --to-layout kitti --class-map car=Car",
        "And from there to KITTI's"},
       {"arbox convert 000008.bin scan.pcd", "KITTI scan to binary PCD"},
       {"arbox convert scan.pcd scan.ply --encoding ascii", "To a PLY that people can read"},
       {"arbox convert sweep.bin sweep.csv --channels x,y,z,intensity,ring",
        "A .bin whose columns are named here"},
       {"cat scan.pcd | arbox convert - - --to bin > scan.bin", "In a pipe"}});
  command->callback([flags] { convert(*flags); });
}

}  // namespace arbox::cli
