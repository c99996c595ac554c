#include "arbox/detectors/pv_rcnn/internal/map_plan.h"

#include <ATen/ops/empty.h>

#include <algorithm>
#include <array>
#include <oneapi/dnnl/dnnl.hpp>
#include <utility>

namespace arbox::detectors::pv_rcnn::internal {
namespace {

using dnnl::memory;
using Tag = memory::format_tag;

constexpr auto kFloat = memory::data_type::f32;

/// One primitive with its packed parameters.
struct Step {
  dnnl::convolution_forward primitive;
  memory::desc source, result, scratch;
  memory weight, bias;
};

/// The way back of one block: a 1x1 convolution to `factor`^2 times the channels, whose parts are
/// the cells of the finer map.
struct UpStep {
  Step step;
  std::int64_t channels, factor;
};

memory packed(const at::Tensor& tensor, const memory::desc& plain, const memory::desc& wanted,
              const dnnl::engine& engine, dnnl::stream& stream) {
  memory from(plain, engine, tensor.data_ptr<float>()), to(wanted, engine);
  dnnl::reorder(from, to).execute(stream, from, to);
  stream.wait();
  return to;
}

/// weight (out, in, k, k) contiguous.
Step make_step(const at::Tensor& weight, const at::Tensor& bias, std::int64_t stride,
               const memory::dims& source, const dnnl::engine& engine) {
  const std::int64_t kernel = weight.size(2), padding = kernel / 2;
  const auto side = [&](std::int64_t n) { return (n + 2 * padding - kernel) / stride + 1; };
  const memory::dims result = {source[0], weight.size(0), side(source[2]), side(source[3])};
  const memory::dims weights(weight.sizes().begin(), weight.sizes().end());
  dnnl::post_ops after;
  after.append_eltwise(1.0f, dnnl::algorithm::eltwise_relu, 0.0f, 0.0f);
  dnnl::primitive_attr attributes;
  attributes.set_post_ops(after);
  attributes.set_scratchpad_mode(dnnl::scratchpad_mode::user);
  const auto describe = [&](dnnl::algorithm algorithm) {
    const dnnl::convolution_forward::desc wanted(
        dnnl::prop_kind::forward_inference, algorithm, memory::desc(source, kFloat, Tag::any),
        memory::desc(weights, kFloat, Tag::any), memory::desc({weights[0]}, kFloat, Tag::x),
        memory::desc(result, kFloat, Tag::any), {stride, stride}, {padding, padding},
        {padding, padding});
    return dnnl::convolution_forward::primitive_desc(wanted, attributes, engine, true);
  };
  dnnl::convolution_forward::primitive_desc chosen;
  if (kernel == 3 && stride == 1) chosen = describe(dnnl::algorithm::convolution_winograd);
  if (!chosen) chosen = describe(dnnl::algorithm::convolution_direct);
  dnnl::stream stream(engine);
  return {
      dnnl::convolution_forward(chosen),
      chosen.src_desc(),
      chosen.dst_desc(),
      chosen.scratchpad_desc(),
      packed(weight, memory::desc(weights, kFloat, Tag::oihw), chosen.weights_desc(), engine,
             stream),
      packed(bias, memory::desc({weights[0]}, kFloat, Tag::x), chosen.bias_desc(), engine, stream)};
}

/// Memory of one run, used again and again: maps go to and fro between two places, reordered ones
/// to a third, primitives scratch in a fourth. Fresh memory would cost a page fault every 4 KiB.
class Workspace {
 public:
  enum Place { kMap, kOtherMap, kReordered, kScratch, kPlaces };

  explicit Workspace(const std::array<std::size_t, kPlaces>& bytes) {
    for (int place = 0; place < kPlaces; ++place) {
      memory_[place] = at::empty({static_cast<std::int64_t>(bytes[place])}, at::kByte);
    }
  }
  memory at_place(Place place, const memory::desc& wanted, const dnnl::engine& engine) {
    return {wanted, engine, memory_[place].data_ptr()};
  }

 private:
  std::array<at::Tensor, kPlaces> memory_;
};

/// Runs a step into `to`, which is not where `source` is.
memory run_step(const Step& step, memory source, Workspace& workspace, Workspace::Place to,
                const dnnl::engine& engine, dnnl::stream& stream) {
  if (source.get_desc() != step.source) {
    memory input = workspace.at_place(Workspace::kReordered, step.source, engine);
    dnnl::reorder(source, input).execute(stream, source, input);
    source = input;
  }
  memory result = workspace.at_place(to, step.result, engine);
  step.primitive.execute(stream, {{DNNL_ARG_SRC, source},
                                  {DNNL_ARG_WEIGHTS, step.weight},
                                  {DNNL_ARG_BIAS, step.bias},
                                  {DNNL_ARG_DST, result},
                                  {DNNL_ARG_SCRATCHPAD,
                                   workspace.at_place(Workspace::kScratch, step.scratch, engine)}});
  stream.wait();
  return result;
}

/// (in, out, k, k) as the (out * k * k, in, 1, 1) of a 1x1 convolution, channels last among the
/// outputs.
at::Tensor as_pointwise(const at::Tensor& weight) {
  return weight.permute({2, 3, 1, 0})
      .reshape({weight.size(2) * weight.size(3) * weight.size(1), weight.size(0), 1, 1})
      .contiguous();
}

}  // namespace

struct MapPlan::Steps {
  dnnl::engine engine{dnnl::engine::kind::cpu, 0};
  std::vector<std::vector<Step>> blocks;
  std::vector<UpStep> ups;
  std::array<std::size_t, Workspace::kPlaces> bytes{};

  void reserve(const Step& step) {
    for (const auto place : {Workspace::kMap, Workspace::kOtherMap}) {
      bytes[place] = std::max(bytes[place], step.result.get_size());
    }
    bytes[Workspace::kReordered] = std::max(bytes[Workspace::kReordered], step.source.get_size());
    bytes[Workspace::kScratch] = std::max(bytes[Workspace::kScratch], step.scratch.get_size());
  }
};

MapPlan::MapPlan(const std::vector<std::vector<FoldedLayer>>& blocks,
                 const std::vector<FoldedLayer>& ups, at::IntArrayRef sizes)
    : sizes_(sizes.vec()) {
  auto steps = std::make_unique<Steps>();
  memory::dims shape(sizes.begin(), sizes.end());
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    std::vector<Step>& block = steps->blocks.emplace_back();
    for (const FoldedLayer& layer : blocks[i]) {
      block.push_back(make_step(layer.weight.contiguous(), layer.bias.contiguous(), layer.stride,
                                shape, steps->engine));
      steps->reserve(block.back());
      shape = block.back().result.dims();
    }
    const std::int64_t factor = ups[i].stride;
    steps->ups.push_back(
        {make_step(as_pointwise(ups[i].weight), ups[i].bias.repeat({factor * factor}).contiguous(),
                   1, shape, steps->engine),
         ups[i].weight.size(1), factor});
    steps->reserve(steps->ups.back().step);
  }
  steps_ = std::move(steps);
}

MapPlan::~MapPlan() = default;

at::Tensor MapPlan::run(const at::Tensor& map) const {
  const dnnl::engine& engine = steps_->engine;
  dnnl::stream stream(engine);
  const at::Tensor input = map.contiguous(at::MemoryFormat::ChannelsLast);
  const memory::dims dims(input.sizes().begin(), input.sizes().end());
  memory current(memory::desc(dims, kFloat, Tag::nhwc), engine, input.data_ptr<float>());
  Workspace workspace(steps_->bytes);
  Workspace::Place free = Workspace::kMap;
  std::int64_t channels = 0, begin = 0;
  for (const UpStep& up : steps_->ups) channels += up.channels;
  at::Tensor result;  // (B, H, W, channels)
  for (std::size_t i = 0; i < steps_->blocks.size(); ++i) {
    for (const Step& step : steps_->blocks[i]) {
      current = run_step(step, current, workspace, free, engine, stream);
      free = free == Workspace::kMap ? Workspace::kOtherMap : Workspace::kMap;
    }
    const UpStep& up = steps_->ups[i];
    memory risen = run_step(up.step, current, workspace, free, engine, stream);
    const auto shape = up.step.result.dims();
    const at::Tensor rows = at::empty({shape[0], shape[2], shape[3], shape[1]}, input.options());
    memory to(memory::desc(shape, kFloat, Tag::nhwc), engine, rows.data_ptr<float>());
    dnnl::reorder(risen, to).execute(stream, risen, to);
    stream.wait();
    const std::int64_t k = up.factor;
    if (!result.defined()) {
      result = at::empty({shape[0], shape[2] * k, shape[3] * k, channels}, input.options());
    }
    result.view({shape[0], shape[2], k, shape[3], k, channels})
        .slice(5, begin, begin + up.channels)
        .copy_(rows.view({shape[0], shape[2], shape[3], k, k, up.channels})
                   .permute({0, 1, 3, 2, 4, 5}));
    begin += up.channels;
  }
  return result.permute({0, 3, 1, 2});
}

}  // namespace arbox::detectors::pv_rcnn::internal
