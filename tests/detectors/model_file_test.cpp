#include "arbox/detectors/model_file.h"

#include <ATen/core/ivalue.h>
#include <ATen/ops/arange.h>
#include <ATen/ops/equal.h>
#include <ATen/ops/full.h>
#include <ATen/ops/zeros.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <torch/nn/module.h>

#include "arbox/base/error.h"
#include "arbox/detectors/pv_rcnn/import_openpcdet.h"
#include "arbox/detectors/pv_rcnn/model.h"
#include "support/program.h"
#include "support/refusal.h"

namespace arbox::detectors {
namespace {

using ::arbox::testing::refusal;
using ::testing::AllOf;
using ::testing::HasSubstr;

class Toy : public torch::nn::Module {
 public:
  Toy() {
    weight = register_parameter("weight", at::arange(6, at::kFloat).reshape({2, 3}) / 7);
    bias = register_parameter("bias", at::full({2}, 1.0F / 3));
    mean = register_buffer("running_mean", at::full({2}, 0.1F));
    count = register_buffer("count", at::full({}, std::int64_t{5}, at::kLong));
  }
  at::Tensor weight, bias, mean, count;
};

TEST(ModelFile, TensorsComeBackBitByBit) {
  for (const auto type : {at::kBool, at::kChar, at::kByte, at::kShort, at::kInt, at::kLong,
                          at::kHalf, at::kFloat, at::kDouble}) {
    const at::Tensor tensor = at::arange(6, at::kFloat).reshape({2, 3}).to(type).t();
    const at::Tensor back = to_tensor(to_record(tensor), "r");
    EXPECT_EQ(back.scalar_type(), type);
    EXPECT_TRUE(at::equal(back, tensor));
  }
  EXPECT_EQ(to_tensor(to_record(at::zeros({0, 4})), "r").sizes(), (at::IntArrayRef{0, 4}));
  EXPECT_EQ(to_record(at::zeros({})).shape.size(), 0U);
  EXPECT_THROW(to_record(at::zeros({1}, at::kBFloat16)), InvalidArgument);
  EXPECT_THAT(refusal<Error>([] {
                to_tensor({io::NumberType::kUint16, {1}, "12"}, "r");
              }),
              HasSubstr("r: tensors have no numbers of type uint16"));
  EXPECT_THAT(refusal<Error>([] {
                to_tensor({io::NumberType::kFloat32, {2}, "1234"}, "r");
              }),
              HasSubstr("expected 2 numbers of float32, got 4 bytes"));
}

TEST(ModelFile, HalfPrecisionKeepsStatisticsAndLargeNumbers) {
  Toy toy;
  EXPECT_EQ(records_of(toy).at("weight").type, io::NumberType::kFloat32);
  auto records = records_of(toy, WeightPrecision::kHalf);
  EXPECT_EQ(records.at("weight").type, io::NumberType::kFloat16);
  for (const char* name : {"bias", "running_mean"}) {
    EXPECT_EQ(records.at(name).type, io::NumberType::kFloat32) << name;
  }
  Toy other;
  other.weight.data().zero_();
  load_records(other, records, "m");
  EXPECT_TRUE(at::equal(other.weight, toy.weight.to(at::kHalf).to(at::kFloat)));
  toy.weight.data().fill_(1e5);
  EXPECT_EQ(records_of(toy, WeightPrecision::kHalf).at("weight").type, io::NumberType::kFloat32);
}

TEST(ModelFile, ListsEverythingThatDoesNotFitAndChangesNothing) {
  Toy toy;
  auto records = records_of(toy);
  records.erase("bias");
  records["more"] = records["weight"];
  records["running_mean"].shape = {1, 2};
  records["count"] = to_record(at::zeros({}));
  records["weight"] = to_record(at::full({2, 3}, std::numeric_limits<float>::infinity()));
  EXPECT_THAT(refusal<Error>([&] { load_records(toy, records, "m.arbox"); }),
              AllOf(HasSubstr("m.arbox: "), HasSubstr("'bias' is missing"),
                    HasSubstr("'more' is unknown"), HasSubstr("'weight' holds a non-finite"),
                    HasSubstr("'running_mean' has shape [1, 2], expected [2]"),
                    HasSubstr("'count' has type Float, expected Long")));
  EXPECT_TRUE(at::equal(toy.weight, Toy().weight));
}

evaluation::ConfidenceCalibration made_calibration() {
  evaluation::ConfidenceCalibration calibration;
  calibration.source = "20 made streets";
  calibration.classes["Car"] = {{0.5, 60}, {1.25, 39}};
  return calibration;
}

TEST(ModelFile, PvRcnnKeepsItsNotes) {
  const testing::TemporaryDirectory folder;
  pv_rcnn::Options options;
  options.classes = {"Car"};
  options.voxels.low = {0, -3.2, -3};
  options.voxels.high = {6.4, 3.2, 1};
  for (auto* list :
       {&options.anchors.lengths, &options.anchors.widths, &options.anchors.heights,
        &options.anchors.bottoms, &options.anchors.positive_iou, &options.anchors.negative_iou}) {
    list->resize(1);
  }
  options.regions.grid = 2;
  pv_rcnn::Network network(options);
  const auto file = folder / "m.arbox";
  pv_rcnn::save_model(file, network, {.card = "# Card\n", .calibration = made_calibration()});
  const pv_rcnn::Model model = pv_rcnn::load_model(file);
  EXPECT_EQ(model.notes.card, "# Card\n");
  ASSERT_TRUE(model.notes.calibration);
  EXPECT_EQ(model.notes.calibration->source, "20 made streets");
  EXPECT_FALSE(model.network->is_training());
  EXPECT_EQ(records_of(*model.network), records_of(network));

  const auto info = testing::run_arbox({"info", file.string()});
  EXPECT_THAT(info.output,
              AllOf(HasSubstr("calibration   20 made streets"), HasSubstr("# Card"),
                    HasSubstr("For other scans nothing is promised"),
                    HasSubstr("99 objects, p up to 0.99"), HasSubstr("classes: [Car]")));
  const auto json = testing::run_arbox({"info", file.string(), "--json"});
  EXPECT_THAT(json.output, AllOf(HasSubstr("\"source\": \"20 made streets\""),
                                 HasSubstr("\"kind\": \"pv_rcnn\"")));

  io::ModelArchive archive = io::read_model_archive(file);
  archive.classes = {"Van"};
  EXPECT_THAT(refusal<Error>([&] { pv_rcnn::to_model(archive, "m"); }),
              HasSubstr("expected the classes of the configuration (Car), got Van"));
  archive.kind = "other";
  EXPECT_THAT(refusal<Error>([&] { pv_rcnn::to_model(archive, "m"); }),
              HasSubstr("a model of kind pv_rcnn, got 'other'"));
  archive = io::read_model_archive(file);
  archive.calibration = "{}";
  EXPECT_THAT(refusal<Error>([&] { pv_rcnn::to_model(archive, "m"); }),
              HasSubstr("m: calibration.json"));
  archive = io::read_model_archive(file);
  archive.configuration = "classes: [Car]\nvoxel: 1\n";
  EXPECT_THAT(refusal<Error>([&] { pv_rcnn::to_model(archive, "m"); }),
              HasSubstr("unknown key 'voxel'"));
}

}  // namespace
}  // namespace arbox::detectors
