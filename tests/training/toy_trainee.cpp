#include "training/toy_trainee.h"

#include <ATen/TensorOperators.h>
#include <ATen/core/grad_mode.h>
#include <ATen/ops/dropout.h>
#include <ATen/ops/full.h>
#include <ATen/ops/linear.h>
#include <ATen/ops/ones.h>
#include <ATen/ops/randn.h>
#include <ATen/ops/relu.h>
#include <ATen/ops/tensor.h>
#include <ATen/ops/zeros.h>

#include <chrono>
#include <cmath>
#include <limits>
#include <thread>
#include <vector>

#include "arbox/base/error.h"
#include "arbox/base/random.h"
#include "arbox/sparse/layers.h"
#include "arbox/sparse/voxel_tensor.h"
#include "arbox/training/weights_file.h"

namespace arbox::training::testing {
namespace {

sparse::SparseTensor voxels_of(std::span<const Scene> scenes, at::ScalarType type) {
  std::vector<sparse::Voxels> voxels;
  for (const Scene& scene : scenes) {
    voxels.push_back(sparse::voxelize(scene.cloud.view(), {"intensity"},
                                      {.voxel_size = {0.5, 0.5, 0.5}, .feature = "mean"}));
  }
  const sparse::SparseTensor tensor = sparse::to_sparse_tensor(voxels);
  return tensor.with_features(tensor.features().to(type));
}

at::Tensor targets_of(std::span<const Scene> scenes, at::ScalarType type) {
  std::vector<double> numbers;
  for (const Scene& scene : scenes) {
    const Eigen::Vector3d& center = scene.objects.at(0).box.center;
    numbers.insert(numbers.end(), center.data(), center.data() + 3);
  }
  return at::tensor(numbers, at::kDouble).reshape({-1, 3}).to(type);
}

}  // namespace

Scene ToyScenes::scene(std::int64_t index) const {
  if (index == missing) throw IoError("scene " + std::to_string(index) + ": no such file");
  const RandomStream random(seed_, static_cast<std::uint64_t>(index), 1);
  Scene scene;
  scene.source = "toy scene " + std::to_string(index);
  SceneObject object;
  for (int axis = 0; axis < 3; ++axis) {
    object.box.center[axis] = random.uniform(static_cast<std::uint32_t>(axis), -3, 3);
  }
  object.box.size = {1, 1, 1};
  object.box.rotation = Eigen::Quaterniond::Identity();
  scene.cloud.channels = {"intensity"};
  const std::uint32_t points = 20 + random.below(3, 150);
  for (std::uint32_t i = 0; i < points; ++i) {
    for (std::uint32_t axis = 0; axis < 3; ++axis) {
      const double spread = random.normal(10 + 4 * i + axis);
      scene.cloud.values.push_back(static_cast<float>(object.box.center[axis] + spread));
    }
    scene.cloud.values.push_back(static_cast<float>(random.uniform(13 + 4 * i)));
  }
  if (index == poisoned) object.box.center.x() = std::numeric_limits<double>::quiet_NaN();
  scene.objects = {object};
  return scene;
}

class ToyTrainee::Network : public torch::nn::Module {
 public:
  Network()
      : conv1_(register_module("conv1", std::make_shared<sparse::Convolution>(4, 8))),
        norm1_(register_module("norm1", std::make_shared<sparse::VoxelBatchNorm>(8))),
        conv2_(register_module("conv2", std::make_shared<sparse::Convolution>(
                                            8, 16, sparse::Kernel{.stride = {2, 2, 2}}))),
        norm2_(register_module("norm2", std::make_shared<sparse::VoxelBatchNorm>(16))),
        weight_(register_parameter("weight", at::randn({3, 16}) * 0.1)),
        bias_(register_parameter("bias", at::zeros({3}))),
        unused_(register_parameter("unused", at::ones({2}))) {}

  /// (scenes, 3)
  at::Tensor forward(const sparse::SparseTensor& input, bool dropout) {
    using sparse::relu;
    const auto hidden = relu(norm1_->forward(conv1_->forward(input)));
    const auto output = relu(norm2_->forward(conv2_->forward(hidden)));
    const at::Tensor rows =
        dropout ? at::dropout(output.features(), 0.2, is_training()) : output.features();
    const at::Tensor scene = output.batch_numbers();
    const auto sums = [&](const at::Tensor& values) {
      return at::zeros({input.batch_size(), values.size(1)}, values.options())
          .index_add(0, scene, values);
    };
    const at::Tensor counts = sums(at::ones({output.size(), 1}, rows.options()));
    return at::linear(sums(rows) / counts, weight_, bias_);
  }

 private:
  std::shared_ptr<sparse::Convolution> conv1_;
  std::shared_ptr<sparse::VoxelBatchNorm> norm1_;
  std::shared_ptr<sparse::Convolution> conv2_;
  std::shared_ptr<sparse::VoxelBatchNorm> norm2_;
  at::Tensor weight_, bias_, unused_;
};

ToyTrainee::ToyTrainee(const ToyOptions& options) : options_(options) {
  at::manual_seed(options.seed);
  network_ = std::make_shared<Network>();
  if (options.double_precision) network_->to(at::kDouble);
}

ToyTrainee::~ToyTrainee() = default;

torch::nn::Module& ToyTrainee::network() { return *network_; }

void ToyTrainee::prepare(Scene& scene, std::uint64_t seed, std::int64_t place) const {
  const RandomStream random(seed, static_cast<std::uint64_t>(place), 2);
  if (random.uniform(0) < 0.5) return;
  for (std::size_t i = 1; i < scene.cloud.values.size(); i += 4) scene.cloud.values[i] *= -1;
  for (SceneObject& object : scene.objects) object.box.center.y() *= -1;
}

StepLoss ToyTrainee::loss(std::span<const Scene> scenes, const Step& /*step*/,
                          Communicator& processes) {
  if (options_.delay_milliseconds > 0) {
    std::this_thread::sleep_for(std::chrono::milliseconds(options_.delay_milliseconds));
  }
  const auto type = options_.double_precision ? at::kDouble : at::kFloat;
  at::Tensor count = at::full({1}, static_cast<double>(scenes.size()), at::kDouble);
  processes.sum(count);
  const at::Tensor errors =
      network_->forward(voxels_of(scenes, type), options_.dropout) - targets_of(scenes, type);
  const at::Tensor squares = errors.square().sum() / count.item<double>();
  return {squares, {{"squares", squares.item<double>()}}};
}

std::map<std::string, double> ToyTrainee::evaluate(const SceneSource& scenes) {
  const auto type = options_.double_precision ? at::kDouble : at::kFloat;
  double error = 0;
  for (std::int64_t i = 0; i < scenes.size(); ++i) {
    const std::vector<Scene> scene = {scenes.scene(i)};
    error += (network_->forward(voxels_of(scene, type), false) - targets_of(scene, type))
                 .norm()
                 .item<double>();
  }
  error /= static_cast<double>(scenes.size());
  return {{"error", error}, {"closeness", -error}};
}

void ToyTrainee::save(const std::filesystem::path& path) { save_weights(*network_, path); }

}  // namespace arbox::training::testing
