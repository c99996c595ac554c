#include <spdlog/spdlog.h>
#include <CLI/CLI.hpp>
#include <memory>

#include "arbox/base/options.h"
#include "arbox/cli/box_file.h"
#include "arbox/cli/command_line.h"
#include "arbox/cli/commands.h"
#include "arbox/cli/option_flags.h"
#include "arbox/cli/picture_output.h"
#include "arbox/cli/standard_input.h"
#include "arbox/drawing/scene.h"
#include "arbox/io/kitti_calibration.h"
#include "arbox/io/point_cloud_file.h"

namespace arbox::cli {
namespace {

struct ViewFlags {
  std::string cloud, boxes, labels, calibration, image, output;
  io::ReadOptions read;
  drawing::SceneOptions scene;
};

void check(const ViewFlags& flags) {
  require_picture("--output", flags.output);
  if (flags.cloud == "-" && flags.boxes == "-") {
    throw UsageError("only one of --cloud and --boxes can come from standard input");
  }
  if (!flags.image.empty() && flags.calibration.empty()) {
    throw UsageError("--image needs --calib FILE to know where the camera stands");
  }
}

drawing::Photo read_photo(const std::string& path, const io::KittiCalibration& calibration) {
  drawing::Photo photo;
  photo.image = drawing::read_image(path);
  photo.projection = io::image_from_lidar(calibration);
  return photo;
}

void view(const ViewFlags& flags) {
  check(flags);
  const io::PointCloudFile cloud = read_point_cloud_input(flags.cloud, flags.read);
  std::optional<io::KittiCalibration> calibration;
  if (!flags.calibration.empty()) {
    calibration = io::read_kitti_calibration(flags.calibration);
  }
  const std::string scan = std::filesystem::path(flags.cloud).stem().string();
  drawing::Scene scene;
  scene.cloud = cloud.points.view();
  if (!flags.boxes.empty()) {
    scene.predictions = read_boxes(flags.boxes, KittiText::kResults, scan, calibration);
  }
  if (!flags.labels.empty()) {
    scene.truth = read_boxes(flags.labels, KittiText::kLabels, scan, calibration);
  }
  if (!flags.image.empty()) scene.photo = read_photo(flags.image, *calibration);
  const drawing::Image image = drawing::draw_scene(scene, flags.scene);
  drawing::write_image(image, flags.output);
  spdlog::info("{}: {} x {} pixels, {} points, {} predictions, {} labels", flags.output,
               image.width, image.height, cloud.points.size(), scene.predictions.size(),
               scene.truth.size());
}

}  // namespace

void add_view(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "view", "Draw a cloud with boxes from above, in perspective and over a photo; no display");
  const auto flags = std::make_shared<ViewFlags>();
  command
      ->add_option("--cloud", flags->cloud,
                   "Point cloud: .pcd .ply .bin .npy .npz or text; - for standard input")
      ->type_name("FILE")
      ->required();
  command->add_option("--output", flags->output, "Picture to write: .png, .jpg or .jpeg")
      ->type_name("FILE")
      ->required();
  command
      ->add_option(
          "--boxes", flags->boxes,
          "Predictions: JSON or JSON lines of `arbox detect`, CSV boxes, or KITTI results; "
          "- for JSON on standard input")
      ->type_name("FILE");
  command
      ->add_option("--labels", flags->labels,
                   "Ground truth, drawn dashed: KITTI labels, JSON, JSON lines or CSV boxes")
      ->type_name("FILE");
  command
      ->add_option("--calib", flags->calibration,
                   "KITTI calibration; KITTI's boxes and --image need it")
      ->type_name("FILE");
  command->add_option("--image", flags->image, "Photo of the left colour camera")
      ->type_name("FILE");
  add_option_flags(*command, bind_options(flags->scene));
  add_option_flags(*command, bind_options(flags->read), {"keep_non_finite", "scale_intensity"});
  add_examples(
      *command,
      {{"arbox view --cloud 000008.bin --output 000008.png", "The scan alone"},
       {"arbox view --cloud 000008.bin --boxes 000008.json --minimum-score 0.3 --output a.png",
        "What `arbox detect` found in it"},
       {"arbox detect 000008.bin | arbox view --cloud 000008.bin --boxes - --output a.png",
        "The same in a pipe"},
       {"arbox view --cloud velodyne/000008.bin --labels label_2/000008.txt "
        "--calib calib/000008.txt --image image_2/000008.png --output a.png",
        "A KITTI frame with its labels, also over the photo"},
       {"arbox view --cloud room.ply --color rgb --view perspective --elevation 50 --output a.png",
        "A room in its own colours, from further above"}});
  command->callback([flags] { view(*flags); });
}

}  // namespace arbox::cli
