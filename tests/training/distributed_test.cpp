#include <ATen/TensorOperators.h>
#include <ATen/ops/batch_norm.h>
#include <ATen/ops/cat.h>
#include <ATen/ops/randn.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <signal.h>
#include <sys/socket.h>
#include <torch/csrc/autograd/autograd.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <memory>

#include "arbox/base/error.h"
#include "arbox/sparse/layers.h"
#include "arbox/training/checkpoint.h"
#include "arbox/training/gloo_communicator.h"
#include "support/program.h"
#include "training/child.h"

namespace {

using namespace arbox;
using namespace arbox::training;
using namespace arbox::training::testing;
using arbox::testing::TemporaryDirectory;

std::string free_port() {
  const int handle = ::socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t length = sizeof address;
  ::bind(handle, reinterpret_cast<sockaddr*>(&address), length);
  ::getsockname(handle, reinterpret_cast<sockaddr*>(&address), &length);
  ::close(handle);
  return std::to_string(ntohs(address.sin_port));
}

/// The processes of one run, each in a folder of its own as on several machines.
std::vector<std::unique_ptr<Child>> start(int processes, const std::string& folder,
                                          const std::vector<std::string>& arguments) {
  const std::string port = free_port();
  std::vector<std::unique_ptr<Child>> children;
  for (int rank = 0; rank < processes; ++rank) {
    std::vector<std::string> words = {folder + std::to_string(rank)};
    words.insert(words.end(), arguments.begin(), arguments.end());
    children.push_back(std::make_unique<Child>(
        words, std::map<std::string, std::string>{{"MASTER_ADDR", "127.0.0.1"},
                                                  {"MASTER_PORT", port},
                                                  {"RANK", std::to_string(rank)},
                                                  {"OMP_NUM_THREADS", "1"},
                                                  {"WORLD_SIZE", std::to_string(processes)}}));
  }
  return children;
}

enum class Compared { kAll, kParameters };

bool is_parameter(const std::string& name) {
  return name.starts_with("network/") && name.find("running_") == std::string::npos;
}

void expect_near_checkpoint(const std::string& folder, const std::string& expected,
                            double tolerance, Compared compared) {
  const Checkpoint left = read_checkpoint(checkpoint_file(folder));
  const Checkpoint right = read_checkpoint(checkpoint_file(expected));
  EXPECT_EQ(left.step, right.step);
  ASSERT_EQ(left.tensors.size(), right.tensors.size());
  for (const auto& [name, tensor] : left.tensors) {
    const at::Tensor other = right.tensors.at(name);
    if (tensor.numel() == 0 || (compared == Compared::kParameters && !is_parameter(name))) continue;
    EXPECT_LE((tensor - other).abs().max().item<double>(), tolerance) << name;
  }
}

void expect_like_one(int processes, const std::vector<std::string>& arguments, double tolerance,
                     Compared compared = Compared::kAll) {
  const TemporaryDirectory folder;
  const std::string one = folder / "one", many = folder / "many";
  std::vector<std::string> alone = {one};
  alone.insert(alone.end(), arguments.begin(), arguments.end());
  run_toy(alone);
  for (const auto& child : start(processes, many, arguments)) {
    EXPECT_EQ(child->wait(), 0) << child->output();
  }
  expect_near_checkpoint(many + "0", one, tolerance, compared);
}

// Steps are small, so that rounding is not blown up: Adam's first steps are signs of gradients.
TEST(Distributed, TwoProcessesTrainAsOne) {
  expect_like_one(2, {"steps=5", "batch_size=5", "double", "optimizer.epsilon=0.001"}, 1e-9);
  expect_like_one(2, {"steps=5", "batch_size=5", "optimizer.epsilon=0.001"}, 1e-4);
}

TEST(Distributed, TwoProcessesTrainPvRcnnAsOne) {
  const std::vector<std::string> words = {"pv_rcnn", "steps=5", "batch_size=3",
                                          "schedule.learning_rate=0.001",
                                          "optimizer.epsilon=0.001"};
  auto in_double = words;
  in_double.push_back("double");
  expect_like_one(2, in_double, 1e-9);
  // Statistics of norms and moments of the optimiser have other scales.
  expect_like_one(2, words, 1e-4, Compared::kParameters);
}

TEST(Distributed, ThreeProcessesWithAccumulationTrainAsOne) {
  expect_like_one(3,
                  {"steps=5", "batch_size=6", "accumulate=2", "double", "average=0.5", "validate",
                   "validation_interval=2", "optimizer.epsilon=0.001"},
                  1e-9);
}

TEST(Distributed, AResumedRunGoesOnAsOne) {
  const TemporaryDirectory folder;
  const std::string whole = folder / "whole", parts = folder / "parts";
  const std::vector<std::string> words = {"steps=20", "batch_size=4"};
  for (const auto& child : start(2, whole, words)) EXPECT_EQ(child->wait(), 0) << child->output();
  auto slow = words;
  slow.push_back("delay=20");
  const auto children = start(2, parts, slow);
  ASSERT_TRUE(children[1]->wait_for_line("step 3")) << children[1]->output();
  // One process is asked to end: all do, at the same step.
  children[1]->send(SIGTERM);
  for (const auto& child : children) {
    EXPECT_EQ(child->wait(), 0) << child->output();
    EXPECT_NE(child->output().find("end 1 after"), std::string::npos) << child->output();
  }
  auto resumed = words;
  resumed.push_back("resume");
  for (const auto& child : start(2, parts, resumed)) EXPECT_EQ(child->wait(), 0) << child->output();
  expect_same_checkpoint(parts + "0", whole + "0");
}

TEST(Distributed, ALostProcessEndsTheRunWithACheckpointAndAMessage) {
  for (const std::size_t victim : {std::size_t{1}, std::size_t{0}}) {
    const TemporaryDirectory folder;
    const std::string run = folder / "run";
    const auto children =
        start(2, run, {"steps=100000", "batch_size=2", "delay=10", "process_timeout=20"});
    for (const auto& child : children) {
      ASSERT_TRUE(child->wait_for_line("step 3")) << child->output();
    }
    children[victim]->send(SIGKILL);
    const auto began = std::chrono::steady_clock::now();
    Child& survivor = *children[1 - victim];
    EXPECT_EQ(survivor.wait(30), 1) << survivor.output();
    EXPECT_LT(std::chrono::steady_clock::now() - began, std::chrono::seconds(25));
    EXPECT_NE(survivor.output().find("data-parallel run: process"), std::string::npos)
        << survivor.output();
    const Checkpoint checkpoint =
        read_checkpoint(checkpoint_file(run + std::to_string(1 - victim)));
    EXPECT_GE(checkpoint.step, 3);
  }
}

TEST(Distributed, AProcessThatHangsEndsTheRunAfterTheTimeout) {
  const TemporaryDirectory folder;
  const std::string run = folder / "run";
  const auto children =
      start(2, run, {"steps=100000", "batch_size=2", "delay=10", "process_timeout=2"});
  ASSERT_TRUE(children[0]->wait_for_line("step 3")) << children[0]->output();
  children[1]->send(SIGSTOP);
  EXPECT_EQ(children[0]->wait(20), 1) << children[0]->output();
  EXPECT_TRUE(std::filesystem::exists(checkpoint_file(run + "0")));
}

TEST(Distributed, AProcessThatNeverComesIsAnError) {
  const ProcessGroup group{0, 2, "127.0.0.1", static_cast<std::uint16_t>(std::stoi(free_port()))};
  EXPECT_THROW(GlooCommunicator(group, 0.5), IoError);
}

TEST(Distributed, WrongEnvironmentIsNamed) {
  const auto with = [](const char* name, const char* value, const char* message) {
    ::setenv(name, value, 1);
    try {
      ProcessGroup::from_environment();
      ADD_FAILURE() << name << '=' << value;
    } catch (const ConfigError& error) {
      EXPECT_NE(std::string(error.what()).find(message), std::string::npos) << error.what();
    }
  };
  EXPECT_EQ(ProcessGroup::from_environment().size, 1);
  with("WORLD_SIZE", "two", "WORLD_SIZE");
  ::setenv("WORLD_SIZE", "2", 1);
  with("RANK", "2", "RANK: expected a whole number from 0 to 1, got '2'");
  ::unsetenv("RANK");
  ::setenv("RANK", "1", 1);
  with("MASTER_PORT", "70000", "MASTER_PORT");
  ::setenv("MASTER_PORT", "1234", 1);
  const ProcessGroup group = ProcessGroup::from_environment();
  EXPECT_EQ(group.rank, 1);
  EXPECT_EQ(group.master_port, 1234);
  for (const char* name : {"WORLD_SIZE", "RANK", "MASTER_PORT"}) ::unsetenv(name);
}

/// With sums that double, one process stands for two with the same rows.
TEST(SharedStatistics, GradientsOfSharedBatchNorm) {
  const sparse::SharedStatistics shared([](at::Tensor& numbers) { numbers.mul_(2); });
  sparse::BatchNorm norm(3);
  norm.to(at::kDouble);
  const at::Tensor weights = at::randn({7, 3}, at::kDouble);
  const at::Tensor rows = (at::randn({7, 3}, at::kDouble) * 2 + 100).set_requires_grad(true);
  at::Tensor shared_gradient, plain_gradient;
  const auto gradient = [&](const at::Tensor& input, const at::Tensor& factors) {
    const at::Tensor output = norm.forward(input);
    return torch::autograd::grad({(output * factors).sum()}, {rows})[0];
  };
  shared_gradient = gradient(rows, weights);
  const at::Tensor running = norm.named_buffers()["running_var"].clone();
  {
    // Two processes with the same rows are one process with the rows twice.
    sparse::BatchNorm plain(3);
    plain.to(at::kDouble);
    const at::Tensor twice = at::cat({rows, rows});
    const at::Tensor output =
        at::batch_norm(twice, norm.named_parameters()["weight"], norm.named_parameters()["bias"],
                       {}, {}, true, 0.1, 1e-5, false);
    plain_gradient =
        torch::autograd::grad({(output * at::cat({weights, weights})).sum()}, {rows})[0] / 2;
    const at::Tensor variance = twice.detach().var(0, true);
    EXPECT_TRUE(running.allclose(0.9 + 0.1 * variance, 1e-9));
  }
  EXPECT_TRUE(shared_gradient.allclose(plain_gradient, 1e-8, 1e-10))
      << (shared_gradient - plain_gradient).abs().max().item<double>();
}

TEST(SharedStatistics, NoRowsHereStillTakesPart) {
  int calls = 0;
  const sparse::SharedStatistics shared([&](at::Tensor& numbers) {
    ++calls;
    numbers.add_(8);
  });
  sparse::BatchNorm norm(2);
  const at::Tensor rows = at::randn({0, 2}).set_requires_grad(true);
  const at::Tensor output = norm.forward(rows);
  EXPECT_EQ(calls, 1);
  EXPECT_EQ(output.size(0), 0);
  torch::autograd::backward({output.sum()}, {});
  EXPECT_EQ(calls, 2);
}

TEST(SharedStatistics, EvalModeAndOtherThreadsKeepToThemselves) {
  const sparse::SharedStatistics shared([](at::Tensor&) { FAIL() << "nothing to be shared"; });
  sparse::BatchNorm norm(2);
  norm.eval();
  EXPECT_EQ(norm.forward(at::randn({4, 2})).size(0), 4);
}

}  // namespace
