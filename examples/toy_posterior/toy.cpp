#include "arbox/examples/toy_posterior/toy.h"

#include <ATen/TensorOperators.h>
#include <ATen/ops/arange.h>
#include <ATen/ops/cat.h>
#include <ATen/ops/empty.h>
#include <ATen/ops/full_like.h>
#include <ATen/ops/meshgrid.h>
#include <ATen/ops/ones.h>
#include <ATen/ops/stack.h>
#include <ATen/ops/zeros.h>
#include <torch/optim/adam.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "arbox/base/random.h"
#include "arbox/heads/quantizer.h"

namespace arbox::examples {

using at::Tensor;

namespace {

constexpr double kPi = std::numbers::pi, kWidth = 2.0, kHeight = 1.5;
constexpr int kCells = kLengths * kPositions * kHeadings;

double bump(double distance) { return std::exp(-0.5 * distance * distance); }

double around(int bin, double peak) {
  const double off = std::abs(bin - peak);
  return bump(std::min(off, kHeadings - off));
}

/// Weights that sum to one.
std::vector<double> normalized(std::vector<double> weights) {
  const double sum = std::accumulate(weights.begin(), weights.end(), 0.0);
  for (double& weight : weights) weight /= sum;
  return weights;
}

std::vector<double> headings(bool can) {
  std::vector<double> weights;
  for (int bin = 0; bin < kHeadings; ++bin) {
    weights.push_back(can ? 1.0 : around(bin, 3.0) + around(bin, 10.5));
  }
  return normalized(weights);
}

std::vector<double> positions(int length) {
  std::vector<double> weights;
  for (int bin = 0; bin < kPositions; ++bin) weights.push_back(bump(2.0 * (bin - length)));
  return normalized(weights);
}

/// (cells, 3) bins of every cell.
Tensor cells() {
  const auto grid =
      at::meshgrid({at::arange(kLengths, at::kLong), at::arange(kPositions, at::kLong),
                    at::arange(kHeadings, at::kLong)},
                   "ij");
  return at::stack({grid[0].reshape(-1), grid[1].reshape(-1), grid[2].reshape(-1)}, 1);
}

Tensor boxes_of_cells(const Tensor& bins) {
  const ToyCodec codec;
  const heads::HeadInput input = toy_input(bins.size(0));
  return codec.decode(heads::dequantize(bins, codec.components()).unsqueeze(1), input.references)
      .select(1, 0);
}

}  // namespace

ToyCodec::ToyCodec()
    : components_{{"length", 0.5, 8.0, kLengths, false},
                  {"x", -1.75, 2.0, kPositions, false},
                  {"yaw", 0.0, kPi, kHeadings + 1, true}} {}

Tensor ToyCodec::encode(const Tensor& boxes, const heads::References&) const {
  const Tensor yaw = 2 * boxes.select(-1, 9).atan2(boxes.select(-1, 6));
  return at::stack({boxes.select(-1, 3), boxes.select(-1, 0), yaw - kPi * (yaw / kPi).floor()}, -1);
}

Tensor ToyCodec::decode(const Tensor& components, const heads::References&) const {
  const Tensor length = components.select(-1, 0), half = 0.5 * components.select(-1, 2);
  const Tensor zero = length * 0;
  return at::stack({components.select(-1, 1), zero, zero, length, at::full_like(length, kWidth),
                    at::full_like(length, kHeight), half.cos(), zero, zero, half.sin()},
                   -1);
}

heads::ComponentSet ToyCodec::equivalents(const Tensor& boxes,
                                          const heads::References& references) const {
  return {encode(boxes, references).unsqueeze(1), at::ones({boxes.size(0), 1}, at::kBool)};
}

Tensor ToyCodec::encode_sizes(const Tensor& sizes, const heads::References&) const {
  return sizes.slice(-1, 0, 1);
}

ToyJoint toy_joint() {
  ToyJoint joint;
  for (int length = 0; length < kLengths; ++length) {
    const double can = bump(1.2 * (length - 3)), beam = bump(0.8 * (length - 11));
    const auto of_can = headings(true), of_beam = headings(false);
    for (const double position : positions(length)) {
      for (int yaw = 0; yaw < kHeadings; ++yaw) {
        joint.push_back(position * (can * of_can[yaw] + beam * of_beam[yaw]));
      }
    }
  }
  return normalized(joint);
}

heads::HeadContext toy_context() {
  return {.features = 1, .condition = 0, .codec = std::make_shared<ToyCodec>()};
}

heads::HeadInput toy_input(std::int64_t count) {
  Tensor identity = at::zeros({count, 4});
  identity.select(1, 0).fill_(1);
  return {at::ones({count, 1}), {at::zeros({count, 3}), identity, at::ones({count, 3})}, {}};
}

Tensor draw_boxes(const ToyJoint& joint, std::int64_t count, std::uint64_t seed) {
  std::vector<double> cumulative(joint.size());
  std::partial_sum(joint.begin(), joint.end(), cumulative.begin());
  const RandomStream random(seed, 0, 0);
  Tensor index = at::empty({count}, at::kLong);
  for (std::int64_t i = 0; i < count; ++i) {
    const double target = random.uniform(static_cast<std::uint32_t>(i)) * cumulative.back();
    const auto found = std::upper_bound(cumulative.begin(), cumulative.end(), target);
    index.data_ptr<std::int64_t>()[i] =
        std::min<std::ptrdiff_t>(found - cumulative.begin(), kCells - 1);
  }
  return boxes_of_cells(cells().index_select(0, index));
}

void fit(heads::BoxHead& head, int steps, std::int64_t batch) {
  constexpr double kRate = 5e-3;
  torch::optim::Adam optimizer(head.parameters(), torch::optim::AdamOptions(kRate));
  const ToyJoint joint = toy_joint();
  const heads::HeadInput input = toy_input(batch);
  for (int step = 0; step < steps; ++step) {
    const double rate = kRate * 0.5 * (1 + std::cos(kPi * step / steps));
    static_cast<torch::optim::AdamOptions&>(optimizer.param_groups()[0].options()).lr(rate);
    optimizer.zero_grad();
    const Tensor boxes = draw_boxes(joint, batch, static_cast<std::uint64_t>(step) + 1);
    head.loss(input, boxes).per_object.mean().backward();
    optimizer.step();
  }
}

ToyJoint joint_of(heads::BoxHead& head) {
  const Tensor density =
      head.forward(toy_input(kCells))->log_density(boxes_of_cells(cells())).exp().to(at::kDouble);
  const double* first = density.data_ptr<double>();
  return normalized({first, first + kCells});
}

double total_variation(const ToyJoint& first, const ToyJoint& second) {
  double sum = 0.0;
  for (std::size_t i = 0; i < first.size(); ++i) sum += std::abs(first[i] - second[i]);
  return 0.5 * sum;
}

}  // namespace arbox::examples
