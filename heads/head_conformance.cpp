#include "arbox/heads/head_conformance.h"

#include <ATen/TensorOperators.h>
#include <ATen/ops/allclose.h>
#include <ATen/ops/arange.h>
#include <ATen/ops/isfinite.h>
#include <ATen/ops/zeros.h>

#include <array>
#include <cmath>
#include <exception>
#include <limits>

#include "arbox/base/error.h"
#include "arbox/base/random.h"
#include "arbox/heads/box_tensor.h"
#include "arbox/heads/parameters.h"
#include "arbox/heads/quartile_codec.h"
#include "arbox/heads/yaw_codecs.h"

namespace arbox::heads {
namespace {

using at::Tensor;

constexpr std::int64_t kObjects = 12, kFeatures = 8;
constexpr int kDraws = 16, kBeams = 5;

struct Objects {
  HeadInput input;
  Tensor boxes;
};

Tensor normals(std::int64_t rows, std::int64_t columns, std::uint64_t seed) {
  const RandomStream random(seed, 0, 0);
  Tensor result = at::zeros({rows, columns});
  for (std::int64_t i = 0; i < rows * columns; ++i) {
    result.data_ptr<float>()[i] = static_cast<float>(random.normal(static_cast<std::uint32_t>(i)));
  }
  return result;
}

/// Boxes near references of 3 to 5 m.
Objects make_objects(const HeadContext& context, std::int64_t count) {
  std::vector<geometry::Box> frames, boxes;
  for (std::int64_t i = 0; i < count; ++i) {
    const RandomStream random(11, static_cast<std::uint64_t>(i), 1);
    const auto u = [&](std::uint32_t draw) { return random.uniform(draw); };
    const double edge = 3 + 2 * u(0);
    const double turn = context.codec->upright() ? u(1) : 0.0;
    frames.push_back(
        geometry::make_yaw_box({20 * u(2), 20 * u(3), u(4)}, {edge, edge, edge}, turn));
    boxes.push_back(geometry::make_yaw_box(
        frames.back().center + Eigen::Vector3d(u(5), u(6), u(7)),
        edge * Eigen::Vector3d(0.7 + 0.3 * u(8), 0.9 + 0.3 * u(9), 0.8 + 0.3 * u(10)),
        turn + u(11)));
    if (context.codec->upright()) continue;
    boxes.back().rotation = geometry::Quaternion(random.normal(12), random.normal(13),
                                                 random.normal(14), random.normal(15))
                                .normalized();
  }
  const Tensor rows = to_tensor(frames);
  Objects objects;
  objects.input.features = normals(count, context.features, 1);
  objects.input.references = {rows.slice(1, 0, 3), rows.slice(1, 6, 10), rows.slice(1, 3, 6)};
  if (context.condition > 0) objects.input.condition = normals(count, context.condition, 2);
  objects.boxes = to_tensor(boxes);
  return objects;
}

Tensor ids(std::int64_t count) { return at::arange(count, at::kLong); }

Tensor rows(std::initializer_list<std::int64_t> index) {
  Tensor result = at::zeros({static_cast<std::int64_t>(index.size())}, at::kLong);
  std::copy(index.begin(), index.end(), result.data_ptr<std::int64_t>());
  return result;
}

bool near(const Tensor& a, const Tensor& b) {
  return a.sizes() == b.sizes() && at::allclose(a, b, 1e-3, 1e-3);
}

/// The share of rows (last dimension) that are near.
double share_near(const Tensor& a, const Tensor& b) {
  if (a.sizes() != b.sizes()) return 0.0;
  return ((a - b).abs() <= 1e-3 + 1e-3 * b.abs()).all(-1).to(at::kDouble).mean().item<double>();
}

template <class Exception, class Call>
bool throws(const Call& call, const std::string& part = "") {
  try {
    call();
  } catch (const Exception& error) {
    return std::string(error.what()).find(part) != std::string::npos;
  } catch (const std::exception&) {
    return false;
  }
  return false;
}

/// Collects what is broken in one setting.
class Check {
 public:
  Check(const HeadMaker& make, HeadContext context, std::string setting,
        std::vector<std::string>& violations)
      : make_(make),
        context_(std::move(context)),
        setting_(std::move(setting)),
        violations_(violations),
        head_(make(context_)),
        objects_(make_objects(context_, kObjects)) {}

  void run() {
    part("shapes", [&] {
      shapes(0);
      shapes(1);
      shapes(kObjects);
    });
    part("independence", [&] { independence(); });
    part("likelihood", [&] { likelihood(); });
    part("known sizes", [&] { known_sizes(); });
    part("loss", [&] { loss(); });
    part("parameters", [&] { parameters(); });
    part("refusals", [&] { refusals(); });
    part("training", [&] { training(); });
  }

 private:
  template <class Body>
  void part(const char* name, const Body& body) {
    try {
      body();
    } catch (const std::exception& error) {
      fail(std::string(name) + ": throws " + error.what());
    }
  }

  void fail(const std::string& text) { violations_.push_back(setting_ + ": " + text); }
  void expect(bool kept, const std::string& text) {
    if (!kept) fail(text);
  }

  void draws(const Draws& got, const BoxDistribution& of, std::int64_t count, bool exact,
             const std::string& name) {
    const bool shape = got.boxes.dim() == 3 && got.boxes.size(0) == of.size() &&
                       got.boxes.size(2) == kBoxColumns && got.boxes.size(1) >= 1 &&
                       (exact ? got.boxes.size(1) == count : got.boxes.size(1) <= count);
    expect(shape, name + ": boxes are not (N, K, 10)");
    if (!shape) return;
    const bool dense = of.measure() == Measure::kDensity;
    expect(dense == got.log_density.defined(),
           name + ": log_density does not agree with measure()");
    expect(!dense || got.log_density.sizes() == got.boxes.sizes().slice(0, 2),
           name + ": log_density is not (N, K)");
    to_boxes(got.boxes.reshape({-1, kBoxColumns}));
    const Tensor norm = got.boxes.slice(2, 6, 10).square().sum(-1);
    expect(norm.numel() == 0 || (norm - 1).abs().max().item<double>() < 1e-3,
           name + ": quaternions are not of unit norm");
  }

  void shapes(std::int64_t count) {
    const Objects objects = make_objects(context_, count);
    const auto distribution = head_->forward(objects.input);
    expect(distribution->size() == count, "size() is not the number of objects");
    const Draws best = distribution->mode({.beam_width = kBeams});
    draws(best, *distribution, kBeams, false, "mode");
    draws(distribution->sample(kDraws, {5, ids(count)}), *distribution, kDraws, true, "sample");
    expect(distribution->mean().sizes() == (std::vector<std::int64_t>{count, kBoxColumns}),
           "mean() is not (N, 10)");
    to_boxes(distribution->mean());
    if (best.log_density.defined() && best.log_density.numel() > 0) {
      const std::int64_t beams = best.log_density.size(1);
      const Tensor gain = best.log_density.slice(1, 1) - best.log_density.slice(1, 0, beams - 1);
      expect((gain <= 1e-5).all().item<bool>(), "mode() is not ordered best first");
    }
    if (distribution->measure() == Measure::kDensity) {
      expect(distribution->log_density(objects.boxes).sizes() == (std::vector<std::int64_t>{count}),
             "log_density() is not (N)");
    }
    const HeadLoss result = head_->loss(objects.input, objects.boxes);
    expect(result.per_object.sizes() == (std::vector<std::int64_t>{count}),
           "per_object is not (N)");
    for (const auto& [name, term] : result.terms) {
      expect(term.sizes() == (std::vector<std::int64_t>{count}), "term '" + name + "' is not (N)");
    }
  }

  void independence() {
    const auto all = head_->forward(objects_.input);
    const Tensor some = rows({7, 2});
    const auto alone = head_->forward(objects_.input.select(some));
    const auto selected = all->select(some);
    const Draws drawn = all->sample(kDraws, {5, ids(kObjects)});
    expect(drawn.boxes.equal(all->sample(kDraws, {5, ids(kObjects)}).boxes),
           "equal streams give different draws");
    const Tensor expected = drawn.boxes.index_select(0, some);
    for (const auto* other : {alone.get(), selected.get()}) {
      expect(share_near(other->sample(kDraws, {5, some}).boxes, expected) > 0.9,
             "an object's draws depend on the batch");
      expect(share_near(other->mode({.beam_width = 1}).boxes,
                        all->mode({.beam_width = 1}).boxes.index_select(0, some)) == 1.0,
             "an object's mode depends on the batch");
    }
  }

  void likelihood() {
    const auto distribution = head_->forward(objects_.input);
    if (distribution->measure() == Measure::kNone) {
      expect(throws<NotAvailable>([&] { distribution->log_density(objects_.boxes); }),
             "log_density() without a likelihood must throw NotAvailable");
      return;
    }
    const Tensor density = distribution->log_density(objects_.boxes);
    const Tensor some = rows({3, 9});
    expect(near(distribution->select(some)->log_density(objects_.boxes.index_select(0, some)),
                density.index_select(0, some)),
           "an object's density depends on the batch");
    const Draws best = distribution->mode({.beam_width = 1});
    const Tensor of_box = distribution->log_density(best.boxes.select(1, 0));
    // Free codecs supervise a choice of a box's vectors; only those count.
    expect(!context_.codec->upright() ||
               (of_box >= best.log_density.select(1, 0) - 2e-2).all().item<bool>(),
           "a box is less likely than its own vector");
  }

  void known_sizes() {
    const Tensor sizes = objects_.boxes.slice(1, 3, 6);
    std::unique_ptr<BoxDistribution> given;
    try {
      given = head_->forward(objects_.input)->given_sizes(sizes);
    } catch (const NotAvailable&) {
      return;
    }
    const Tensor boxes = given->sample(kDraws, {5, ids(kObjects)}).boxes;
    expect(near(boxes.slice(2, 3, 6), sizes.unsqueeze(1).expand({kObjects, kDraws, 3})),
           "given_sizes(): draws have other sizes");
    draws(given->mode({.beam_width = kBeams}), *given, kBeams, false, "mode of known sizes");
    density_of_sizes();
  }

  /// p(box | h) = p(size | h) p(rest | size, h), where a box has one vector.
  void density_of_sizes() {
    const auto distribution = head_->forward(objects_.input);
    const Tensor boxes = distribution->sample(1, {5, ids(kObjects)}).boxes.select(1, 0);
    const Tensor sizes = boxes.slice(1, 3, 6);
    if (distribution->measure() == Measure::kNone) {
      expect(throws<NotAvailable>([&] { distribution->log_size_density(sizes); }),
             "log_size_density() without a likelihood must throw NotAvailable");
      return;
    }
    Tensor density;
    try {
      density = distribution->log_size_density(sizes);
    } catch (const NotAvailable&) {
      return;
    }
    expect(density.sizes() == (std::vector<std::int64_t>{kObjects}),
           "log_size_density() is not (N)");
    const ComponentSet set = context_.codec->equivalents(boxes, objects_.input.references);
    if (set.mask.size(1) > 1) return;
    expect(near(distribution->log_density(boxes),
                density + distribution->given_sizes(sizes)->log_density(boxes)),
           "log_size_density() and given_sizes() do not make log_density()");
  }

  void loss() {
    HeadInput input = objects_.input;
    input.features = input.features.clone().requires_grad_();
    const HeadLoss result = head_->loss(input, objects_.boxes);
    expect(at::isfinite(result.per_object).all().item<bool>(), "losses are not finite");
    result.per_object.sum().backward();
    const Tensor gradient = input.features.grad();
    expect(gradient.defined() && at::isfinite(gradient).all().item<bool>() &&
               gradient.abs().max().item<double>() > 0,
           "no finite gradient reaches the features");
    for (const auto& parameter : head_->named_parameters()) {
      const Tensor& of = parameter.value().grad();
      expect(of.defined() && at::isfinite(of).all().item<bool>(),
             "no finite gradient reaches the parameter '" + parameter.key() + "'");
    }
    head_->zero_grad();
    const Tensor some = rows({4, 1, 8});
    expect(near(head_->loss(objects_.input.select(some), objects_.boxes.index_select(0, some))
                    .per_object,
                result.per_object.index_select(0, some)),
           "an object's loss depends on the batch");
  }

  void parameters() {
    const auto other = make_(context_);
    load_parameters(*other, parameters_of(*head_), "conformance");
    expect(other->forward(objects_.input)
               ->mode({.beam_width = 1})
               .boxes.equal(head_->forward(objects_.input)->mode({.beam_width = 1}).boxes),
           "loaded parameters give other answers");
  }

  void refusals() {
    HeadInput input = objects_.input;
    input.features = at::zeros({kObjects, context_.features + 1});
    expect(throws<InvalidArgument>([&] { head_->forward(input); }),
           "features of a wrong width must throw InvalidArgument");
    input.features = objects_.input.features.clone();
    input.features[3][1] = std::numeric_limits<float>::quiet_NaN();
    expect(throws<NumericalError>([&] { head_->forward(input); }, "features") &&
               throws<NumericalError>([&] { head_->loss(input, objects_.boxes); }, "features"),
           "NaN features must throw NumericalError that names the tensor");
    expect(
        throws<InvalidArgument>([&] { head_->loss(objects_.input, objects_.boxes.slice(0, 1)); }),
        "another number of targets must throw InvalidArgument");
    const auto distribution = head_->forward(objects_.input);
    expect(throws<InvalidArgument>([&] { distribution->mode({.beam_width = 0}); }) &&
               throws<InvalidArgument>([&] {
                 distribution->sample(0, {5, ids(kObjects)});
               }) &&
               throws<InvalidArgument>([&] {
                 distribution->sample(1, {5, ids(1)});
               }),
           "no beams, no draws and missing object ids must throw InvalidArgument");
  }

  void training() {
    constexpr int kSteps = 30;
    constexpr double kRate = 1e-2;
    const auto total = [&] {
      return head_->loss(objects_.input, objects_.boxes).per_object.mean();
    };
    const double before = total().item<double>();
    for (int step = 0; step < kSteps; ++step) {
      head_->zero_grad();
      total().backward();
      at::NoGradGuard no_gradient;
      for (Tensor& parameter : head_->parameters()) {
        const Tensor& gradient = parameter.grad();
        const double norm = gradient.norm().item<double>();
        if (norm > 0) parameter.sub_(gradient * (kRate * parameter.norm().item<double>() / norm));
      }
    }
    const double after = total().item<double>();
    expect(after < before, "training on one batch does not lower the loss, " +
                               std::to_string(before) + " became " + std::to_string(after));
  }

  const HeadMaker& make_;
  HeadContext context_;
  std::string setting_;
  std::vector<std::string>& violations_;
  std::shared_ptr<BoxHead> head_;
  Objects objects_;
};

struct Setting {
  const char* name;
  std::shared_ptr<const BoxCodec> codec;
};

std::array<Setting, 4> settings() {
  YawCodecOptions residual = ResidualCodec::defaults(), scaled = ScaledCodec::defaults();
  QuartileCodecOptions quartile;
  residual.bins = scaled.bins = quartile.bins = 64;
  quartile.size_high = 4;
  quartile.center_low = -4;
  quartile.center_high = 4;
  return {{{"residual codec", std::make_shared<ResidualCodec>(residual)},
           {"scaled codec", std::make_shared<ScaledCodec>(scaled)},
           {"scaled codec without yaw", std::make_shared<ScaledCodec>(scaled, false)},
           {"quartile codec", std::make_shared<QuartileCodec>(quartile)}}};
}

}  // namespace

std::vector<std::string> head_violations(const HeadMaker& make) {
  std::vector<std::string> violations;
  int taken = 0;
  for (const Setting& setting : settings()) {
    for (const std::int64_t condition : {0, 3}) {
      const std::string name =
          std::string(setting.name) + (condition > 0 ? ", with condition" : "");
      try {
        Check check(make, {.features = kFeatures, .condition = condition, .codec = setting.codec},
                    name, violations);
        check.run();
        ++taken;
      } catch (const ConfigError&) {
      } catch (const NotAvailable&) {
      }
    }
  }
  if (taken == 0) violations.emplace_back("takes none of the codecs");
  return violations;
}

}  // namespace arbox::heads
