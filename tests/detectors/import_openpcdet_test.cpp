#include "arbox/detectors/pv_rcnn/import_openpcdet.h"

#include <ATen/TensorOperators.h>
#include <ATen/ops/allclose.h>
#include <ATen/ops/equal.h>
#include <ATen/ops/stack.h>
#include <ATen/ops/zeros.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <random>

#include "arbox/base/error.h"
#include "arbox/heads/parameters.h"
#include "arbox/io/npz.h"
#include "arbox/io/point_cloud_file.h"
#include "arbox/sparse/layers.h"
#include "support/program.h"

namespace arbox::detectors::pv_rcnn {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

/// KITTI's network on 6.4 x 6.4 m and with thinner layers.
Options small_options() {
  Options options = autoregressive_reference_options();
  options.voxels.low = {0, -3.2, -3};
  options.voxels.high = {6.4, 3.2, 1};
  options.birds_eye.channels = {16, 16};
  options.birds_eye.layers = {2, 2};
  options.birds_eye.up_channels = {16, 16};
  options.keypoints.count = 128;
  options.keypoints.weighting = {16, 16};
  options.regions.shared = options.regions.confidence = options.regions.residuals = {32, 32};
  options.regions.grid = 3;
  options.head.options = {"hidden=[16, 32]", "circular_ends=distinct"};
  options.proposals.count = 8;
  options.post.score = 0.0;
  return options;
}

/// The name that the authors' checkpoints have.
std::string reference_name(std::string name) {
  const std::string ours = "roi_head.box_head.";
  return name.starts_with(ours) ? "roi_head." + name.substr(ours.size()) : name;
}

void write_entries(const std::filesystem::path& file, const Options& options) {
  std::ofstream lines(file);
  for (const auto& [name, tensor] : heads::parameters_of(Network(options))) {
    lines << reference_name(name);
    for (const std::int64_t size : tensor.sizes()) lines << ' ' << size;
    lines << '\n';
  }
}

/// The folder that make_openpcdet.py fills, once.
std::filesystem::path made(const std::string& name) {
  static const testing::TemporaryDirectory folder;
  static const testing::RunResult result = [] {
    write_entries(folder / "entries.txt", small_options());
    std::filesystem::create_directory(folder / "models");
    return testing::run("/usr/bin/python3", {ARBOX_MAKE_OPENPCDET, folder.path().string()});
  }();
  EXPECT_EQ(result.exit_code, 0) << result.errors;
  return folder / name;
}

Import imported(const std::string& name, SparseLayout layout = SparseLayout::kAutomatic) {
  return import_openpcdet(made(name), {.network = small_options(), .layout = layout});
}

std::string refusal(const std::string& name, ImportOptions options) {
  try {
    import_openpcdet(made(name), options);
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

geometry::PointCloud made_cloud() {
  geometry::PointCloud cloud{.channels = {"intensity"}, .values = {}};
  std::mt19937 random(3);
  std::uniform_real_distribution<float> unit(0, 1);
  for (int i = 0; i < 3000; ++i) {
    cloud.values.insert(cloud.values.end(), {6.4F * unit(random), 6.4F * unit(random) - 3.2F,
                                             2.0F * unit(random) - 2.0F, unit(random)});
  }
  return cloud;
}

class EveryLayout : public ::testing::TestWithParam<std::pair<const char*, SparseLayout>> {};
INSTANTIATE_TEST_SUITE_P(Import, EveryLayout,
                         ::testing::Values(std::pair{"spconv2.pth", SparseLayout::kSpconv2},
                                           std::pair{"spconv1.pth", SparseLayout::kSpconv1},
                                           std::pair{"native.pth", SparseLayout::kSpconv2Native},
                                           std::pair{"plain.pth", SparseLayout::kSpconv2},
                                           std::pair{"evil.pth", SparseLayout::kSpconv2}));

TEST_P(EveryLayout, PutsEveryEntryInItsPlace) {
  const auto [file, layout] = GetParam();
  const Import result = imported(file);
  EXPECT_EQ(result.report.layout, layout);
  EXPECT_THAT(result.report.unused, IsEmpty());
  const io::NpzFile expected = io::open_npz(made("expected.npz"));
  const auto tensors = heads::parameters_of(*result.model.network);
  EXPECT_EQ(tensors.size(), expected.names().size());
  EXPECT_EQ(result.report.entries, static_cast<std::int64_t>(tensors.size()));
  for (const auto& [name, tensor] : tensors) {
    if (name.ends_with("num_batches_tracked")) continue;
    const auto numbers = expected.read(reference_name(name)).values<float>();
    ASSERT_EQ(numbers.size(), static_cast<std::size_t>(tensor.numel())) << name;
    EXPECT_TRUE(std::equal(numbers.begin(), numbers.end(), tensor.data_ptr<float>())) << name;
  }
  EXPECT_FALSE(std::filesystem::exists(made("evil")));
}

// What the layout means is told by PyTorch's dense convolution.
TEST_P(EveryLayout, ConvolvesAsADenseConvolutionDoes) {
  const auto tensors = heads::parameters_of(*imported(GetParam().first).model.network);
  const at::Tensor weight = tensors.at("backbone_3d.conv_input.0.weight");
  const io::NpzFile file = io::open_npz(made("convolution.npz"));
  const auto read = [&](const char* name) {
    const io::NpyArray array = file.read(name);
    return to_tensor(
        {.type = array.header().type, .shape = array.shape(), .data = std::string(array.data())},
        name);
  };
  const at::Tensor x = read("x");
  const at::Tensor coordinates = at::stack({at::zeros_like(x), x, read("y"), read("z")}, 1);
  const sparse::Lattice lattice{.grid = sparse::Triple{7, 5, 6}};
  sparse::GridConvolution layer(weight.size(4), weight.size(0), {.submanifold = true});
  heads::load_parameters(layer, {{"weight", weight}}, "test");
  const sparse::SparseTensor input(coordinates, read("features"), lattice);
  const sparse::SparseTensor output = layer.forward(input);
  ASSERT_TRUE(at::equal(output.coordinates(), input.coordinates()));
  EXPECT_TRUE(at::allclose(output.features(), read("expected"), 1e-4, 1e-5));
}

TEST(Import, GivesAModelThatRuns) {
  Import result = imported("spconv1.pth");
  EXPECT_THAT(result.model.notes.card, AllOf(HasSubstr("epoch 80, OpenPCDet pcdet+0.5.2+0"),
                                             HasSubstr("cannot be asked for boxes of known")));
  save_model(made("small.arbox"), *result.model.network, result.model.notes);
  const auto loaded = load_pv_rcnn(made("small.arbox"));
  const PvRcnn direct(result.model.network);
  const geometry::PointCloud cloud = made_cloud();
  const DetectionRequest request{.quantiles = {0.2}};
  const auto first = direct.detect(cloud.view(), request).detections;
  const auto second = loaded->detect(cloud.view(), request).detections;
  ASSERT_FALSE(first.empty());
  ASSERT_EQ(first.size(), second.size());
  for (std::size_t i = 0; i < first.size(); ++i) {
    EXPECT_EQ(first[i].score, second[i].score);
    EXPECT_EQ(first[i].box.center, second[i].box.center);
    EXPECT_EQ(first[i].quantile_boxes.size(), 1U);
  }
}

TEST(Import, TheProgramDetectsWithTheModel) {
  const Import result = imported("spconv2.pth");
  save_model(made("models/small.arbox"), *result.model.network);
  io::write_point_cloud(made("cloud.pcd"), made_cloud().view());
  testing::RunOptions with_models;
  with_models.environment["ARBOX_MODEL_PATH"] = made("models").string();
  const std::string cloud = made("cloud.pcd").string();
  const auto by_name = testing::run_arbox(
      {"detect", cloud, "--model", "small", "--score", "0", "--quantile", "0.2"}, with_models);
  EXPECT_THAT(by_name.output, AllOf(HasSubstr("quantile_boxes"), HasSubstr("\"uncertainty\"")))
      << by_name.errors;
  const auto by_path = testing::run_arbox(
      {"detect", cloud, "--model", made("models/small.arbox").string(), "--score", "0", "--set",
       "post.detections=1", "--set", "post.box=pointwise"});
  EXPECT_THAT(by_path.output, HasSubstr("\"score\"")) << by_path.errors;
  EXPECT_LT(by_path.output.size(), by_name.output.size());
  const auto mean =
      testing::run_arbox({"detect", cloud, "--model", "small", "--mode", "mean"}, with_models);
  EXPECT_EQ(mean.exit_code, 0) << mean.errors;
  const auto refused = [&](std::vector<std::string> more, int exit_code, const char* part) {
    more.insert(more.begin(), {"detect", cloud, "--model"});
    testing::expect_one_line_error(testing::run_arbox(more, with_models), exit_code, {part});
  };
  refused({"smell"}, 1, "unknown model 'smell', nearest is 'small'");
  refused({"small", "--confidence", "0.9"}, 1, "calibration");
  refused({"small", "--detector", "cluster_fit"}, 2, "--model");
  refused({"small", "--head", "gaussian"}, 2, "unknown head 'gaussian'");
  refused({"small", "--mode", "best"}, 2, "--mode");
  refused({"small", "--set", "post.boks=mean"}, 2, "nearest is 'post.box'");
  refused({made("entries.txt").string() + ".arbox"}, 1, "no such file");
  testing::expect_one_line_error(
      testing::run_arbox({"detect", cloud, "--detector", "cluster_fit", "--mode", "mean"}), 2,
      {"--model"});
}

TEST(Import, TheShippedModelIsTheDefault) {
  std::filesystem::create_directories(made("shipped"));
  save_model(made("shipped/pv_rcnn_compact.arbox"), *imported("spconv2.pth").model.network);
  io::write_point_cloud(made("cloud.pcd"), made_cloud().view());
  const std::string cloud = made("cloud.pcd").string();
  testing::RunOptions shipped;
  shipped.environment["ARBOX_MODEL_PATH"] = made("shipped").string();
  const auto found = [&](std::vector<std::string> more) {
    more.insert(more.begin(), {"detect", cloud, "--score", "0"});
    const auto result = testing::run_arbox(more, shipped);
    EXPECT_EQ(result.exit_code, 0) << result.errors;
    return result.output;
  };
  const std::string named = found({"--model", "pv_rcnn_compact"});
  EXPECT_THAT(named, HasSubstr("\"uncertainty\""));
  EXPECT_EQ(found({}), named);
  EXPECT_EQ(found({"--mode", "mean"}), found({"--model", "pv_rcnn_compact", "--mode", "mean"}));
  EXPECT_NE(found({"--detector", "cluster_fit"}), named);
  const auto refused = [&](const std::vector<std::string>& more, const char* part) {
    std::vector<std::string> words = {"detect", cloud};
    words.insert(words.end(), more.begin(), more.end());
    testing::expect_one_line_error(testing::run_arbox(words, shipped), 2, {part});
  };
  refused({"--detector", "cluster_fit", "--mode", "mean"}, "--model");
  refused({"--config", "options.yaml"}, "--detector");
  refused({"--set", "post.boks=mean"}, "nearest is 'post.box'");
}

TEST(Import, TellsWhatItDoesNotUse) {
  const Import result = imported("more.pth");
  EXPECT_THAT(result.report.unused, ElementsAre("dense_head.extra", "teacher.* (2)"));
}

TEST(Import, ListsAllThatDoesNotFit) {
  const std::string text = refusal("less.pth", {.network = small_options()});
  EXPECT_THAT(text,
              AllOf(HasSubstr("less.pth: does not fit the network"),
                    HasSubstr("missing: dense_head.conv_box.bias; point_head.* ("),
                    HasSubstr("of another shape: dense_head.conv_cls.bias [3], expected [18]"),
                    HasSubstr("without a place in the network: dense_head.extra; teacher.*"),
                    Not(HasSubstr("backbone_3d"))));
  EXPECT_THAT(refusal("spconv2.pth", {}), HasSubstr("backbone_2d.blocks.0.1.weight [16, "));
  EXPECT_THAT(
      refusal("spconv1.pth", {.network = small_options(), .layout = SparseLayout::kSpconv2}),
      HasSubstr("backbone_3d.conv1.0.0.weight [3, 3, 3, 16, 16], expected [16, 3, 3, 3, "));
  Options pointwise = small_options();
  pointwise.head.name = "pointwise";
  pointwise.head.options = {};
  EXPECT_THAT(import_openpcdet(made("spconv2.pth"), {.network = pointwise}).report.unused,
              ElementsAre(HasSubstr("roi_head.autoreg.* (")));
}

TEST(Import, RefusesWhatIsNoCheckpointOfItsKind) {
  EXPECT_THAT(refusal("nothing.pth", {}), HasSubstr("expected a dictionary of tensors"));
  EXPECT_THAT(refusal("bad.pth", {.network = small_options()}),
              HasSubstr("'dense_head.conv_box.bias' holds a non-finite number"));
  EXPECT_THAT(refusal("expected.npz", {}), HasSubstr("without data.pkl"));
  EXPECT_THAT(refusal("entries.txt", {}), HasSubstr("pickle"));
  EXPECT_THAT(refusal("absent.pth", {}), HasSubstr("no such file"));
  EXPECT_THAT(
      refusal("spconv2.pth", {.network = small_options(), .overrides = {"voxels.sice=[1, 1, 1]"}}),
      HasSubstr("nearest is 'voxels.size'"));
}

// Entries as make_openpcdet.py wrote them, at the size of the paper, through the program.
TEST(Import, ReadsTheNetworkOfThePaper) {
  const testing::TemporaryDirectory folder;
  write_entries(folder / "entries.txt", autoregressive_reference_options());
  const auto python =
      testing::run("/usr/bin/python3",
                   {ARBOX_MAKE_OPENPCDET, folder.path().string(), "spconv1.pth", "less.pth"});
  ASSERT_EQ(python.exit_code, 0) << python.errors;
  const std::string model = (folder / "paper.arbox").string();
  const auto run = testing::run_arbox({"import", "openpcdet", (folder / "spconv1.pth").string(),
                                       "--output", model, "--half", "--json"});
  ASSERT_EQ(run.exit_code, 0) << run.errors;
  EXPECT_THAT(run.output, AllOf(HasSubstr("\"parameters\": 16345777"),  // 13,115,697 + 3,230,080
                                HasSubstr("\"layout\": \"spconv1\""),
                                HasSubstr("\"head\": \"autoregressive\"")));
  EXPECT_LT(std::filesystem::file_size(model), 34U << 20);
  const auto info = testing::run_arbox({"info", model});
  EXPECT_THAT(info.output,
              AllOf(HasSubstr("Car, Pedestrian, Cyclist"), HasSubstr("parameters    16345777"),
                    HasSubstr("order: center_size_rotation"),
                    HasSubstr("calibration   none: confidence boxes cannot be asked for")));
  const auto refused = testing::run_arbox(
      {"import", "openpcdet", (folder / "less.pth").string(), "--output", model});
  testing::expect_one_line_error(refused, 1, {"less.pth", "missing: ", "point_head.*"});
}

}  // namespace
}  // namespace arbox::detectors::pv_rcnn
