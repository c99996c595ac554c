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
#include "arbox/cli/picture_output.h"
#include "arbox/cli/standard_input.h"
#include "arbox/cli/viewer_module.h"
#include "arbox/drawing/scene_page.h"
#include "arbox/io/file.h"
#include "arbox/io/kitti_calibration.h"
#include "arbox/io/point_cloud_file.h"

namespace arbox::cli {
namespace {

struct ViewFlags {
  std::string cloud, boxes, labels, calibration, image, output, html;
  bool interactive = false;
  std::string dataset, scene_name;
  io::DatasetOptions dataset_options;
  bool color_given = false, azimuth_given = false, captions_given = false;
  io::ReadOptions read;
  drawing::SceneOptions scene;
};

/// From a camera that looks down into a bin to a frame whose x axis is up in its image and whose z
/// axis comes towards it, as pictures from above have them.
Eigen::Matrix3d bin_from_camera() {
  Eigen::Matrix3d turn;
  turn << 0, -1, 0, -1, 0, 0, 0, 0, -1;
  return turn;
}

/// Points and boxes of a bin in that frame.
io::LabeledScene seen_from_above(io::LabeledScene scene) {
  Eigen::Isometry3d turn = Eigen::Isometry3d::Identity();
  turn.linear() = bin_from_camera();
  for (std::size_t i = 0; i < scene.cloud.size(); ++i) {
    Eigen::Map<Eigen::Vector3f> point(scene.cloud.values.data() + i * scene.cloud.columns());
    point = (turn.linear().cast<float>() * point).eval();
  }
  for (io::LabeledObject& object : scene.objects) {
    object.box = geometry::transformed(object.box, turn);
  }
  return scene;
}

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
  const io::LabeledScene shown = loaded.images ? seen_from_above(loaded)
                                 : loaded.frame == io::SceneFrame::kCamera
                                     ? io::converted(loaded, io::SceneFrame::kRoom)
                                     : loaded;
  drawing::Scene scene;
  scene.cloud = shown.cloud.view();
  scene.truth = to_truth(shown.objects);
  for (const io::LabeledObject& object : shown.objects) {
    scene.truth_has_front.push_back(object.heading == io::Heading::kKnown);
  }
  if (!flags.boxes.empty()) {
    scene.predictions = read_boxes(flags.boxes, KittiText::kResults, shown.name, shown.calibration);
  }
  drawing::SceneOptions options = flags.scene;
  if (!flags.color_given && scene.cloud.find("r") != nullptr) {
    options.color = drawing::PointColor::kRgb;
  }
  // Rooms are seen from where depth cameras stand, which look along y; all objects of a bin are
  // "object".
  if (!flags.azimuth_given && shown.frame == io::SceneFrame::kRoom) options.azimuth = -110.0;
  if (!flags.captions_given && loaded.images) options.captions = false;
  if (shown.photo) {
    scene.photo = {drawing::read_image(shown.photo->path), shown.photo->projection};
  }
  if (loaded.images) {
    scene.photo = drawing::Photo{masked_picture(*loaded.images), {}};
    scene.photo->projection.setZero();
    scene.photo->projection.leftCols<3>() =
        loaded.images->intrinsic * bin_from_camera().transpose();
  }
  present(flags, scene, options, shown.name);
}

void view(const ViewFlags& flags) {
  check(flags);
  if (!flags.dataset.empty()) {
    view_dataset(flags);
    return;
  }
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
  present(flags, scene, flags.scene, scan);
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
