#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <ATen/ops/ones.h>
#include <ATen/ops/zeros.h>

#include <map>
#include <numbers>

#include "arbox/base/error.h"
#include "arbox/detectors/pv_rcnn/box_coding.h"
#include "arbox/heads/parameters.h"
#include "arbox/heads/yaw_codecs.h"
#include "detectors/pv_rcnn/small_network.h"

namespace arbox::detectors::pv_rcnn {
namespace {

using Shape = std::vector<std::int64_t>;
using Names = std::map<std::string, Shape>;

/// Names and shapes of the published network's state, from the rules of its layers.
class PublishedState {
 public:
  PublishedState() {
    sparse("conv_input", 4, 16, 3, 3);
    sparse("conv1.0", 16, 16, 3, 3);
    const std::vector<std::int64_t> channels = {16, 32, 64, 64};
    for (int level = 1; level < 4; ++level) {
      for (int i = 0; i < 3; ++i) {
        sparse("conv" + std::to_string(level + 1) + "." + std::to_string(i),
               channels[i == 0 ? level - 1 : level], channels[level], 3, 3);
      }
    }
    sparse("conv_out", 64, 128, 3, 1);
    const std::vector<std::int64_t> sources = {16, 32, 64, 64}, widths = {16, 32, 64, 64};
    for (int i = 0; i < 4; ++i) {
      abstraction("pfe.SA_layers." + std::to_string(i), sources[i], widths[i]);
    }
    abstraction("pfe.SA_rawpoints", 1, 16);
    layer("pfe.vsa_point_feature_fusion", 0, {128, 640});
    for (int block = 0; block < 2; ++block) {
      const std::int64_t out = block == 0 ? 128 : 256, in = block == 0 ? 256 : 128;
      for (int i = 0; i < 6; ++i) {
        layer("backbone_2d.blocks." + std::to_string(block), 1 + 3 * i,
              {out, i == 0 ? in : out, 3, 3});
      }
      transposed("backbone_2d.deblocks." + std::to_string(block), {out, 256, block + 1, block + 1});
    }
    biased("dense_head.conv_cls", {18, 512, 1, 1});
    biased("dense_head.conv_box", {42, 512, 1, 1});
    biased("dense_head.conv_dir_cls", {12, 512, 1, 1});
    layer("point_head.cls_layers", 0, {256, 640});
    layer("point_head.cls_layers", 3, {256, 256});
    biased("point_head.cls_layers.6", {1, 256});
    abstraction("roi_head.roi_grid_pool_layer", 128, 64);
    layer("roi_head.shared_fc_layer", 0, {256, 27648, 1});
    layer("roi_head.shared_fc_layer", 4, {256, 256, 1});
    for (const std::string branch : {"cls", "reg"}) {
      layer("roi_head." + branch + "_layers", 0, {256, 256, 1});
      layer("roi_head." + branch + "_layers", 4, {256, 256, 1});
      biased("roi_head." + branch + "_layers.7", {branch == "cls" ? 1 : 7, 256, 1});
    }
  }

  Names names;

 private:
  void norm(const std::string& name, std::int64_t channels) {
    for (const char* part : {".weight", ".bias", ".running_mean", ".running_var"}) {
      names[name + part] = {channels};
    }
    names[name + ".num_batches_tracked"] = {};
  }
  void layer(const std::string& sequence, int place, const Shape& weight) {
    names[sequence + "." + std::to_string(place) + ".weight"] = weight;
    norm(sequence + "." + std::to_string(place + 1), weight[0]);
  }
  void transposed(const std::string& sequence, const Shape& weight) {
    names[sequence + ".0.weight"] = weight;
    norm(sequence + ".1", weight[1]);
  }
  void biased(const std::string& name, const Shape& weight) {
    names[name + ".weight"] = weight;
    names[name + ".bias"] = {weight[0]};
  }
  void sparse(const std::string& name, std::int64_t in, std::int64_t out, std::int64_t z,
              std::int64_t xy) {
    layer("backbone_3d." + name, 0, {out, z, xy, xy, in});
  }
  void abstraction(const std::string& name, std::int64_t in, std::int64_t width) {
    for (const char* radius : {"0", "1"}) {
      layer(name + ".mlps." + radius, 0, {width, in + 3, 1, 1});
      layer(name + ".mlps." + radius, 3, {width, width, 1, 1});
    }
  }
};

Names state_of(const Network& network) {
  Names names;
  for (const auto& [name, tensor] : heads::parameters_of(network)) {
    names[name] = tensor.sizes().vec();
  }
  return names;
}

std::int64_t parameter_count(const Network& network) {
  std::int64_t sum = 0;
  for (const auto& tensor : network.parameters()) sum += tensor.numel();
  return sum;
}

std::string config(const char* name) { return std::string(ARBOX_CONFIGS) + "/" + name; }

TEST(PvRcnnStructure, KittiHasThePublishedNamesAndShapes) {
  const Network network(read_options<Options>(config("pv_rcnn_kitti.yaml")));
  EXPECT_EQ(state_of(network), PublishedState().names);
  EXPECT_EQ(parameter_count(network), 13115697);
}

TEST(PvRcnnStructure, AutoregressiveHeadAddsThePapersParameters) {
  Options options = read_options<Options>(config("pv_rcnn_kitti.yaml"));
  options.head.name = "autoregressive";
  const Network network(options);
  EXPECT_EQ(parameter_count(network), 13115697 + 3230080);
  Names expected = PublishedState().names;
  const Shape widths = {0, 128, 256, 512, 512};
  for (int component = 0; component < 7; ++component) {
    for (int layer = 0; layer < 4; ++layer) {
      const std::string name = "roi_head.box_head.autoreg." + std::to_string(component) + "." +
                               std::to_string(2 * layer);
      expected[name + ".weight"] = {widths[layer + 1],
                                    layer == 0 ? 256 + 7 + component : widths[layer]};
      expected[name + ".bias"] = {widths[layer + 1]};
    }
  }
  EXPECT_EQ(state_of(network), expected);
}

TEST(PvRcnnStructure, DefaultsAreThePublishedNetwork) {
  Options options = read_options<Options>(config("pv_rcnn_kitti.yaml"));
  options.head.codec.order = Options{}.head.codec.order;
  EXPECT_EQ(options_yaml(options), options_yaml(Options{}));
}

TEST(PvRcnnStructure, CompactLooksAllAround) {
  const Options options = read_options<Options>(config("pv_rcnn_compact.yaml"));
  const Network network(options);
  EXPECT_EQ(options.voxels.low[0], -options.voxels.high[0]);
  EXPECT_EQ(anchor_cells(options), (std::array<std::int64_t, 2>{352, 352}));
  EXPECT_EQ(network.anchors().size(0), 352 * 352 * 6);
}

TEST(PvRcnnStructure, EveryViolationIsListed) {
  const auto options = override_options(
      small_options(true),
      {"birds_eye.layers=[1]", "anchors.widths=[1]", "keypoints.points.samples=[16]"});
  try {
    const Network network(options);
    FAIL() << "accepted";
  } catch (const ConfigError& error) {
    EXPECT_THAT(error.what(), testing::AllOf(testing::HasSubstr("birds_eye.layers"),
                                             testing::HasSubstr("anchors.widths"),
                                             testing::HasSubstr("keypoints.points.samples")));
  }
  EXPECT_THROW(Network(small_options(true, {"voxels.high=[16.1, 8, 1]"})), ConfigError);
  EXPECT_THROW(Network(small_options(true, {"backbone.out_stride=1", "backbone.out_kernel=1"})),
               ConfigError);
  EXPECT_THROW(Network(small_options(false, {"head.options=['hidden=[3]']"})), ConfigError);
}

TEST(PvRcnnAnchors, StandWhereThePublishedNetworkHasThem) {
  const at::Tensor anchors = make_anchors(Options{});
  ASSERT_EQ(anchors.size(0), 211200);
  const auto row = [&](std::int64_t y, std::int64_t x, std::int64_t label, std::int64_t turn) {
    const at::Tensor one = anchors[((y * 176 + x) * 3 + label) * 2 + turn];
    return std::vector<float>(one.data_ptr<float>(), one.data_ptr<float>() + 7);
  };
  using testing::FloatNear;
  const auto is = [](std::initializer_list<float> numbers) {
    std::vector<testing::Matcher<float>> matchers;
    for (const float number : numbers) matchers.push_back(FloatNear(number, 1e-5f));
    return testing::ElementsAreArray(matchers);
  };
  EXPECT_THAT(row(0, 0, 0, 0), is({0, -40, -1, 3.9f, 1.6f, 1.56f, 0}));
  EXPECT_THAT(row(0, 1, 0, 1), is({70.4f / 175, -40, -1, 3.9f, 1.6f, 1.56f, 1.57f}));
  EXPECT_THAT(row(1, 0, 1, 0), is({0, -40 + 80.0f / 199, 0.265f, 0.8f, 0.6f, 1.73f, 0}));
  EXPECT_THAT(row(199, 175, 2, 1), is({70.4f, 40, 0.265f, 1.76f, 0.6f, 1.73f, 1.57f}));
}

at::Tensor random_boxes(std::int64_t count, std::uint64_t seed) {
  at::Tensor boxes = at::zeros({count, kBoxNumbers}, at::kDouble);
  for (std::int64_t i = 0; i < count; ++i) {
    const RandomStream stream(seed, static_cast<std::uint64_t>(i), 9);
    for (std::int64_t k = 0; k < 3; ++k) boxes[i][k] = stream.uniform(k, -20, 20);
    for (std::int64_t k = 3; k < 6; ++k) boxes[i][k] = stream.uniform(k, 0.3, 6);
    boxes[i][6] = stream.uniform(6, -3.1, 3.1);
  }
  return boxes;
}

TEST(PvRcnnCoding, DecodingUndoesEncoding) {
  const at::Tensor boxes = random_boxes(50, 1), anchors = random_boxes(50, 2);
  EXPECT_LT(largest_difference(decode_residuals(encode_residuals(boxes, anchors), anchors), boxes),
            1e-12);
  const at::Tensor back = decode_region_residuals(encode_region_residuals(boxes, anchors), anchors);
  EXPECT_LT(largest_difference(back.slice(1, 0, 6), boxes.slice(1, 0, 6)), 1e-12);
  EXPECT_LT(largest_difference((back - boxes).select(1, 6).cos(), at::ones({50}, at::kDouble)),
            1e-12);
  EXPECT_LT(largest_difference(from_box_rows(to_box_rows(boxes)), boxes), 1e-12);
}

TEST(PvRcnnCoding, RegionResidualsAreTheHeadsCodes) {
  const at::Tensor boxes = random_boxes(50, 3), regions = random_boxes(50, 4);
  const at::Tensor rows = to_box_rows(regions);
  auto codec_options = heads::ResidualCodec::defaults();
  codec_options.order = "center_size_rotation";
  codec_options.full_turn = true;
  const heads::ResidualCodec codec(codec_options);
  const at::Tensor codes = codec.encode(
      to_box_rows(boxes), {rows.slice(1, 0, 3), rows.slice(1, 6, 10), rows.slice(1, 3, 6)});
  EXPECT_LT(largest_difference(codes, encode_region_residuals(boxes, regions)), 1e-9);
}

TEST(PvRcnnCoding, DirectionsTellTheHalfTurn) {
  const double offset = AnchorOptions{}.direction_offset;
  const at::Tensor yaws = random_boxes(200, 5).select(1, 6);
  const at::Tensor logits = at::zeros({200, 2}, at::kDouble);
  logits.scatter_(1, direction_of(yaws, offset).unsqueeze(1), 1.0);
  // Known up to half a turn only.
  const at::Tensor resolved = resolve_directions(yaws + std::numbers::pi, logits, offset);
  EXPECT_LT(largest_difference((resolved - yaws).cos(), at::ones({200}, at::kDouble)), 1e-9);
}

}  // namespace
}  // namespace arbox::detectors::pv_rcnn
