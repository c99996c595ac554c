#include "arbox/training/checkpoint.h"

#include <ATen/TensorOperators.h>
#include <ATen/ops/arange.h>
#include <ATen/ops/full.h>
#include <ATen/ops/randn.h>
#include <ATen/ops/zeros.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <memory>

#include "arbox/base/error.h"
#include "arbox/detectors/model_file.h"
#include "arbox/sparse/layers.h"
#include "arbox/training/durable_file.h"
#include "arbox/training/network_state.h"
#include "arbox/training/weights_file.h"
#include "support/program.h"
#include "training/expect_message.h"

namespace {

using namespace arbox;
using namespace arbox::training;
using arbox::testing::slurp;
using arbox::testing::TemporaryDirectory;

std::shared_ptr<sparse::ResidualBlock> block() {
  return std::make_shared<sparse::ResidualBlock>(4, 6, 2);
}

TEST(TensorRecord, KeepsEveryBit) {
  for (const auto type : {at::kFloat, at::kDouble, at::kHalf}) {
    const at::Tensor tensor = at::randn({3, 4}).to(type).t();
    EXPECT_TRUE(detectors::to_tensor(detectors::to_record(tensor), "x").equal(tensor)) << type;
    EXPECT_EQ(detectors::to_tensor(detectors::to_record(tensor), "x").scalar_type(), type);
  }
  for (const auto type : {at::kLong, at::kInt, at::kShort, at::kChar, at::kByte, at::kBool}) {
    EXPECT_TRUE(detectors::to_tensor(detectors::to_record(at::arange(5).to(type)), "x")
                    .equal(at::arange(5).to(type)))
        << type;
  }
  EXPECT_EQ(detectors::to_tensor(detectors::to_record(at::zeros({0, 3})), "x").size(1), 3);
  EXPECT_EQ(detectors::to_tensor(detectors::to_record(at::full({}, 2.5)), "x").item<double>(), 2.5);
  EXPECT_THROW(detectors::to_record(at::zeros({2}, at::kBFloat16)), InvalidArgument);
  EXPECT_THROW(detectors::to_tensor({io::NumberType::kUint16, {1}, "ab"}, "x"), FormatError);
}

TEST(Checkpoint, ComesBackWhole) {
  const TemporaryDirectory folder;
  Checkpoint written;
  written.step = 12;
  written.validated = 10;
  written.skipped = 3;
  written.skipped_in_row = 1;
  written.seconds = 4.25;
  written.best = -0.1;
  written.best_step = 5;
  written.scenes = 77;
  written.options.frozen = {"a.b", "c"};
  written.options.schedule.learning_rate = 0.1 + 0.2;
  written.tensors = {{"network/x", at::randn({3})},
                     {"first_moment/x", at::randn({3}, at::kDouble)}};
  write_checkpoint(folder / "c.arbox", written);
  const Checkpoint read = read_checkpoint(folder / "c.arbox");
  EXPECT_EQ(read.step, 12);
  EXPECT_EQ(read.validated, 10);
  EXPECT_EQ(read.skipped, 3);
  EXPECT_EQ(read.skipped_in_row, 1);
  EXPECT_EQ(read.seconds, 4.25);
  EXPECT_EQ(read.best, -0.1);
  EXPECT_EQ(read.best_step, 5);
  EXPECT_EQ(read.scenes, 77);
  EXPECT_NO_THROW(require_resumable(written.options, read.options));
  for (const auto& [name, tensor] : written.tensors)
    EXPECT_TRUE(read.tensors.at(name).equal(tensor));
}

TEST(Checkpoint, DamageIsNamed) {
  const TemporaryDirectory folder;
  write_checkpoint(folder / "c.arbox", {.tensors = {{"network/x", at::randn({300})}}});
  const std::string whole = slurp(folder / "c.arbox");
  for (const std::size_t length : {std::size_t{0}, whole.size() / 2, whole.size() - 1}) {
    folder.write("cut.arbox", whole.substr(0, length));
    expect_message<FormatError>([&] { read_checkpoint(folder / "cut.arbox"); }, "cut.arbox");
  }
  expect_message<IoError>([&] { read_checkpoint(folder / "none.arbox"); }, "none.arbox");
  save_weights(*block(), folder / "weights.arbox");
  expect_message<FormatError>([&] { read_checkpoint(folder / "weights.arbox"); },
                              "expected the checkpoint of a training run");
}

TEST(DurableFile, ReplacesAndCleansUp) {
  const TemporaryDirectory folder;
  const std::filesystem::path file = folder / "state";
  write_durably(file, "one");
  write_durably(file, "two");
  EXPECT_EQ(slurp(file), "two");
  folder.write("state.unfinished-123", "half");
  remove_unfinished(folder.path());
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder.path()), {}), 1);
  EXPECT_THROW(write_durably(folder / "no" / "state", "x"), IoError);
}

TEST(WeightsFile, HoldsHalfPrecisionWeightsThatAnotherNetworkTakes) {
  const TemporaryDirectory folder;
  const auto from = block(), to = block();
  save_weights(*from, folder / "w.arbox");
  load_weights(*to, folder / "w.arbox");
  const NamedTensors expected = network_tensors(*from);
  for (const auto& [name, tensor] : network_tensors(*to)) {
    EXPECT_TRUE(tensor.allclose(expected.at(name), 1e-3, 1e-3)) << name;
  }
  // As a part of another network, with the rest left alone.
  const at::Tensor before = to->named_parameters()["conv2.kernel"].clone();
  save_weights(*block(), folder / "w.arbox");
  load_weights(*to, folder / "w.arbox", {"conv2"});
  EXPECT_TRUE(to->named_parameters()["conv2.kernel"].equal(before));
}

TEST(WeightsFile, TheMeanLiesBetweenTwoNetworks) {
  const TemporaryDirectory folder;
  const auto other = block(), network = block();
  // What float16 holds without rounding, so that the file is the network.
  for (const auto& [name, tensor] : network_tensors(*other)) {
    if (tensor.is_floating_point()) tensor.detach().copy_(tensor.detach().to(at::kHalf));
  }
  save_weights(*other, folder / "w.arbox");
  NamedTensors before;
  for (const auto& [name, tensor] : network_tensors(*network)) before[name] = tensor.clone();
  average_weights(*network, folder / "w.arbox", 0.25, {"conv2"});
  const NamedTensors target = network_tensors(*other);
  for (const auto& [name, tensor] : network_tensors(*network)) {
    const bool moved = tensor.is_floating_point() && !in_part(name, "conv2");
    const at::Tensor expected =
        moved ? 0.75 * before.at(name) + 0.25 * target.at(name) : before.at(name);
    EXPECT_TRUE(tensor.allclose(expected, 1e-5, 1e-7)) << name;
  }
  EXPECT_FALSE(network_tensors(*network).at("conv1.kernel").equal(before.at("conv1.kernel")));
  average_weights(*network, folder / "w.arbox", 1.0);
  for (const auto& [name, tensor] : network_tensors(*network)) {
    if (tensor.is_floating_point()) {
      EXPECT_TRUE(tensor.equal(target.at(name))) << name;
    }
  }
  for (const double share : {-0.1, 1.1, std::nan("")}) {
    EXPECT_THROW(average_weights(*network, folder / "w.arbox", share), InvalidArgument) << share;
  }
  const auto wider = std::make_shared<sparse::ResidualBlock>(6, 6, 1);
  expect_message<FormatError>([&] { average_weights(*wider, folder / "w.arbox", 0.5); },
                              "conv1.kernel: expected Float [27, 6, 6], got Float [27, 4, 6]");
}

TEST(WeightsFile, WhatDoesNotFitIsListedAndNothingChanges) {
  const TemporaryDirectory folder;
  const auto from = block();
  const auto to = std::make_shared<sparse::ResidualBlock>(6, 6, 1);
  save_weights(*from, folder / "w.arbox");
  const at::Tensor before = to->named_parameters()["conv2.kernel"].clone();
  expect_message<FormatError>([&] { load_weights(*to, folder / "w.arbox"); },
                              "conv1.kernel: expected Float [27, 6, 6], got Float [27, 4, 6]");
  expect_message<FormatError>([&] { load_weights(*to, folder / "w.arbox"); },
                              "unknown downsample.0.kernel");
  EXPECT_TRUE(to->named_parameters()["conv2.kernel"].equal(before));
  at::Tensor(from->named_parameters()["conv1.kernel"]).detach().fill_(1e6);
  expect_message<NumericalError>([&] { save_weights(*from, folder / "w.arbox"); }, "conv1.kernel");
}

TEST(NetworkState, FrozenPartsStandStill) {
  const auto network = block();
  set_training(*network, {"conv1", "norm1.bn"});
  EXPECT_TRUE(network->is_training());
  EXPECT_FALSE(network->named_modules()["norm1.bn"]->is_training());
  EXPECT_TRUE(network->named_modules()["norm2.bn"]->is_training());
  for (const auto& [name, ignored] : trained_parameters(*network)) {
    EXPECT_FALSE(name.starts_with("conv1") || name.starts_with("norm1")) << name;
  }
  expect_message<ConfigError>([&] { set_training(*network, {"conv11"}); }, "nearest is 'conv1'");
  EXPECT_TRUE(in_part("a.b.c", "a.b"));
  EXPECT_FALSE(in_part("a.bc", "a.b"));
}

}  // namespace
