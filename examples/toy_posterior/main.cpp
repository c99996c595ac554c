// toy_posterior FOLDER: trains three heads on the toy world and draws what they believe into
// FOLDER (docs/heads.md shows the pictures).
#include <torch/utils.h>

#include <filesystem>
#include <iostream>
#include <string>
#include <utility>
#include <vector>

#include "arbox/base/random.h"
#include "arbox/drawing/curves.h"
#include "arbox/examples/toy_posterior/toy.h"
#include "arbox/heads/head_registry.h"

namespace {

using namespace arbox;
using namespace arbox::examples;

struct Belief {
  std::string name;
  ToyJoint joint;
};

std::vector<Belief> train_all() {
  std::vector<Belief> beliefs = {{"truth", toy_joint()}};
  Registry registry = heads::make_head_registry();
  for (const char* name : {"autoregressive", "discrete", "gaussian"}) {
    torch::manual_seed(1);
    const auto head = heads::make_head(name, {"hidden=[64, 64]"}, toy_context(), registry);
    fit(*head, 800, 512);
    beliefs.push_back({name, joint_of(*head)});
    std::cout << name << ": total variation from the truth "
              << total_variation(beliefs.back().joint, beliefs.front().joint) << '\n';
  }
  return beliefs;
}

double value(std::size_t component, double bin) {
  static const ToyCodec codec;
  const heads::Component& one = codec.components()[component];
  return one.low + bin * one.step();
}

/// Draws as points, each spread over its cell.
drawing::Panel scatter(const Belief& belief) {
  constexpr std::int64_t kDraws = 700;
  const at::Tensor boxes = draw_boxes(belief.joint, kDraws, 99);
  const RandomStream random(4, 0, 0);
  drawing::Series series{
      .name = {}, .x = {}, .y = {}, .line = drawing::LineStyle::kNone, .markers = true};
  for (std::int64_t i = 0; i < kDraws; ++i) {
    const auto draw = static_cast<std::uint32_t>(2 * i);
    series.x.push_back(boxes[i][3].item<double>() + random.uniform(draw, -0.22, 0.22));
    series.y.push_back(boxes[i][0].item<double>() + random.uniform(draw + 1, -0.11, 0.11));
  }
  return {.title = belief.name,
          .x = {.label = "length (m)", .low = 0.0, .high = 8.5},
          .y = {.label = "x (m)", .low = -2.2, .high = 2.5},
          .series = {series}};
}

/// Probability of each bin of a component among the cells of the lengths that `keep` accepts.
template <class Keep>
std::vector<double> marginal(const ToyJoint& joint, std::size_t component, const Keep& keep) {
  std::vector<double> weights(component == 0 ? kLengths : kHeadings);
  double sum = 0;
  for (std::size_t cell = 0; cell < joint.size(); ++cell) {
    const std::size_t length = cell / (kPositions * kHeadings), yaw = cell % kHeadings;
    if (!keep(length)) continue;
    weights[component == 0 ? length : yaw] += joint[cell];
    sum += joint[cell];
  }
  for (double& weight : weights) weight /= sum;
  return weights;
}

/// The truth as grey bars, what the head believes as a line.
template <class Keep>
drawing::Panel compare(const Belief& truth, const Belief& belief, std::size_t component,
                       const std::string& label, const Keep& keep) {
  drawing::Bars bars{.name = {}, .heights = marginal(truth.joint, component, keep)};
  bars.color = drawing::Color{200, 200, 200};
  drawing::Series line{.name = {}, .x = {}, .y = marginal(belief.joint, component, keep)};
  line.markers = true;
  for (std::size_t bin = 0; bin <= bars.heights.size(); ++bin) {
    const double middle = value(component, static_cast<double>(bin));
    bars.edges.push_back(value(component, static_cast<double>(bin) - 0.5));
    if (bin < bars.heights.size()) line.x.push_back(middle);
  }
  return {.title = belief.name,
          .x = {.label = label},
          .y = {.label = "probability", .low = 0.0, .high = 0.22},
          .series = {line},
          .bars = {bars}};
}

/// A row of panels, one for each head.
template <class Keep>
void add_row(const std::vector<Belief>& beliefs, std::size_t component, const std::string& label,
             const Keep& keep, std::vector<drawing::Panel>& panels) {
  for (std::size_t i = 1; i < beliefs.size(); ++i) {
    panels.push_back(compare(beliefs.front(), beliefs[i], component, label, keep));
  }
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::cerr << "usage: toy_posterior FOLDER\n";
    return 2;
  }
  const std::filesystem::path folder = argv[1];
  const std::vector<Belief> beliefs = train_all();
  std::vector<drawing::Panel> scatters;
  for (const Belief& belief : beliefs) scatters.push_back(scatter(belief));
  drawing::write_image(drawing::draw_figure(scatters, {.title = "Position follows length",
                                                       .columns = 2,
                                                       .panel_width = 460,
                                                       .panel_height = 340}),
                       folder / "toy_correlation.png");
  const drawing::FigureOptions wide = {.columns = 3, .panel_width = 360, .panel_height = 270};
  std::vector<drawing::Panel> bimodal, symmetric;
  add_row(
      beliefs, 0, "length (m)", [](std::size_t) { return true; }, bimodal);
  drawing::write_image(drawing::draw_figure(bimodal, wide), folder / "toy_bimodality.png");
  add_row(
      beliefs, 2, "yaw (rad) of a can, 2 m", [](std::size_t bin) { return bin == 3; }, symmetric);
  add_row(
      beliefs, 2, "yaw (rad) of a beam, 6 m", [](std::size_t bin) { return bin == 11; }, symmetric);
  drawing::write_image(drawing::draw_figure(symmetric, wide), folder / "toy_symmetry.png");
  return 0;
}
