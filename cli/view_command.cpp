#include <spdlog/spdlog.h>
#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>

#include "arbox/base/options.h"
#include "arbox/cli/box_file.h"
#include "arbox/cli/command_line.h"
#include "arbox/cli/commands.h"
#include "arbox/cli/dataset_command.h"
#include "arbox/cli/masked_picture.h"
#include "arbox/cli/option_flags.h"
#include "arbox/cli/picture_frame.h"
#include "arbox/cli/picture_output.h"
#include "arbox/cli/standard_input.h"
#include "arbox/cli/viewer_module.h"
#include "arbox/drawing/scene_page.h"
#include "arbox/io/file.h"
#include "arbox/io/kitti_calibration.h"
#include "arbox/io/point_cloud_file.h"

namespace arbox::cli {
namespace {

// Rooms are seen from where depth cameras stand, which look along y.
constexpr double kRoomAzimuth = -110.0;

struct ViewFlags {
  std::string cloud, frame = "lidar", boxes, labels, calibration, image, output, html;
  bool interactive = false;
  std::string dataset, scene_name;
  io::DatasetOptions dataset_options;
  bool color_given = false, azimuth_given = false, captions_given = false;
  io::ReadOptions read;
  drawing::SceneOptions scene;
};

void check(const ViewFlags& flags) {
  if (flags.output.empty() && flags.html.empty() && !flags.interactive) {
    throw UsageError("view: expected --output FILE, --html FILE or --interactive");
  }
  if (!flags.output.empty()) require_picture("--output", flags.output);
  if (flags.cloud.empty() == flags.dataset.empty()) {
    throw UsageError("view: expected either --cloud FILE or --dataset DIR");
  }
  if (!flags.dataset.empty() && !(flags.labels.empty() && flags.image.empty())) {
    throw UsageError("--dataset brings its own labels and photos: leave out --labels and --image");
  }
  if (flags.cloud == "-" && flags.boxes == "-") {
    throw UsageError("only one of --cloud and --boxes can come from standard input");
  }
  if (flags.frame != "lidar" && !(flags.dataset.empty() && flags.calibration.empty())) {
    throw UsageError(
        "--frame is for --cloud without --calib: datasets and calibrations say theirs");
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

std::vector<geometry::Detection> to_truth(const std::vector<io::LabeledObject>& objects) {
  std::vector<geometry::Detection> truth;
  for (const io::LabeledObject& object : objects) {
    geometry::Detection& one = truth.emplace_back();
    one.label = object.label;
    one.score = 1.0;
    one.box = object.box;
  }
  return truth;
}

/// Shows the scene in each way that is asked for.
void present(const ViewFlags& flags, const drawing::Scene& scene, drawing::SceneOptions options,
             const std::string& name) {
  const std::string counts = std::to_string(scene.cloud.size()) + " points, " +
                             std::to_string(scene.predictions.size()) + " predictions, " +
                             std::to_string(scene.truth.size()) + " labels";
  if (!flags.output.empty()) {
    const drawing::Image image = drawing::draw_scene(scene, options);
    drawing::write_image(image, flags.output);
    spdlog::info("{}: {} x {} pixels, {}", flags.output, image.width, image.height, counts);
  }
  if (options.title.empty()) options.title = name;
  if (!flags.html.empty()) {
    io::write_file(flags.html, drawing::scene_page(scene, options));
    spdlog::info("{}: {}", flags.html, counts);
  }
  if (flags.interactive) view_interactively(scene, options);
}

void view_dataset(const ViewFlags& flags) {
  const auto dataset = io::open_dataset(flags.dataset, flags.dataset_options);
  const io::LabeledScene loaded = find_scene(*dataset, flags.scene_name);
  const Eigen::Matrix3d rotation = picture_from(loaded.frame, loaded.images.has_value());
  geometry::PointCloud cloud = loaded.cloud;
  turn(cloud, rotation);
  drawing::Scene scene;
  scene.cloud = cloud.view();
  scene.truth = to_truth(loaded.objects);
  turn(scene.truth, rotation);
  for (const io::LabeledObject& object : loaded.objects) {
    scene.truth_has_front.push_back(object.heading == io::Heading::kKnown);
  }
  if (!flags.boxes.empty()) {
    scene.predictions =
        read_boxes(flags.boxes, KittiText::kResults, loaded.name, loaded.calibration);
    turn(scene.predictions, rotation);
  }
  drawing::SceneOptions options = flags.scene;
  if (!flags.color_given && scene.cloud.find("r") != nullptr) {
    options.color = drawing::PointColor::kRgb;
  }
  // All objects of a bin are "object".
  const bool room = loaded.frame != io::SceneFrame::kLidar && !loaded.images;
  if (!flags.azimuth_given && room) options.azimuth = kRoomAzimuth;
  if (!flags.captions_given && loaded.images) options.captions = false;
  if (loaded.photo) {
    scene.photo = {drawing::read_image(loaded.photo->path), loaded.photo->projection};
  }
  if (loaded.images) {
    scene.photo = drawing::Photo{masked_picture(*loaded.images), {}};
    scene.photo->projection.setZero();
    scene.photo->projection.leftCols<3>() = loaded.images->intrinsic;
  }
  if (scene.photo) {
    scene.photo->projection.leftCols<3>() *= rotation.transpose();
  }
  present(flags, scene, options, loaded.name);
}

void view(const ViewFlags& flags) {
  check(flags);
  if (!flags.dataset.empty()) {
    view_dataset(flags);
    return;
  }
  io::PointCloudFile cloud = read_point_cloud_input(flags.cloud, flags.read);
  std::optional<io::KittiCalibration> calibration;
  if (!flags.calibration.empty()) {
    calibration = io::read_kitti_calibration(flags.calibration);
  }
  const io::SceneFrame frame = io::frame_named(flags.frame);
  const Eigen::Matrix3d rotation = picture_from(frame, true);
  turn(cloud.points, rotation);
  const std::string scan = std::filesystem::path(flags.cloud).stem().string();
  drawing::Scene scene;
  scene.cloud = cloud.points.view();
  if (!flags.boxes.empty()) {
    scene.predictions = read_boxes(flags.boxes, KittiText::kResults, scan, calibration);
  }
  if (!flags.labels.empty()) {
    scene.truth = read_boxes(flags.labels, KittiText::kLabels, scan, calibration);
  }
  turn(scene.predictions, rotation);
  turn(scene.truth, rotation);
  if (!flags.image.empty()) scene.photo = read_photo(flags.image, *calibration);
  drawing::SceneOptions options = flags.scene;
  if (!flags.azimuth_given && frame == io::SceneFrame::kRoom) options.azimuth = kRoomAzimuth;
  present(flags, scene, options, scan);
}

}  // namespace

void add_view(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "view", "Show a cloud with boxes: as a picture, a page for browsers, or in a window");
  const auto flags = std::make_shared<ViewFlags>();
  command
      ->add_option("--cloud", flags->cloud,
                   "Point cloud: .pcd .ply .bin .npy .npz or text; - for standard input")
      ->type_name("FILE");
  command
      ->add_option(
          "--frame", flags->frame,
          "Frame of --cloud and its boxes: lidar and room have z up; camera has x right, y "
          "down, z forward and is shown as the camera sees it")
      ->check(CLI::IsMember({"lidar", "room", "camera"}))
      ->capture_default_str()
      ->type_name("NAME");
  command->add_option("--dataset", flags->dataset, "Folder of a dataset, in place of --cloud")
      ->type_name("DIR");
  command->add_option("--scene", flags->scene_name, "Scene of the dataset (default: its first one)")
      ->type_name("NAME");
  command->add_option("--output", flags->output, "Picture to write: .png, .jpg or .jpeg")
      ->type_name("FILE");
  command
      ->add_option("--html", flags->html,
                   "Page to write, with the cloud to turn, a quantile slider and details of boxes; "
                   "one file, opens in any browser without a network")
      ->type_name("FILE");
  command->add_flag("--interactive", flags->interactive,
                    "Open a window; n and b step through the quantiles, k shows the samples");
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
  add_option_flags(*command, bind_options(flags->dataset_options));
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
       {"arbox view --dataset sunrgbd_trainval --scene 000001 --output a.png",
        "A scene of a dataset with its labels and photo"},
       {"arbox detect 000008.bin --samples | arbox view --cloud 000008.bin --boxes - --html a.html",
        "A page to turn and step through the quantiles"},
       {"arbox view --cloud depth.pcd --frame camera --color rgb --output a.png",
        "What a depth camera saw, in its own frame"},
       {"arbox view --cloud room.ply --color rgb --view perspective --elevation 50 --output a.png",
        "A room in its own colours, from further above"}});
  command->callback([command, flags] {
    flags->color_given = command->count("--color") > 0;
    flags->azimuth_given = command->count("--azimuth") > 0;
    flags->captions_given = command->count("--captions") > 0;
    view(*flags);
  });
}

}  // namespace arbox::cli
