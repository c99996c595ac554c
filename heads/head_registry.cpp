#include "arbox/heads/head_registry.h"

#include "arbox/base/error.h"
#include "arbox/base/plugin_loader.h"
#include "arbox/heads/autoregressive_head.h"
#include "arbox/heads/built_in_heads.h"
#include "arbox/heads/discrete_head.h"
#include "arbox/heads/four_point_head.h"
#include "arbox/heads/gaussian_head.h"
#include "arbox/heads/pointwise_head.h"

namespace arbox::heads {
namespace {

template <class Head, class Options>
void add(Registrar& registrar, const BuiltInHead& head) {
  registrar.add<HeadKind, Options>(head.name, head.help,
                                   [](const Options& options, const HeadContext& context) {
                                     return std::make_shared<Head>(options, context);
                                   });
}

}  // namespace

void register_heads(Registrar& registrar) {
  add<AutoregressiveHead, AutoregressiveOptions>(registrar, kAutoregressive);
  add<DiscreteHead, DiscreteOptions>(registrar, kDiscrete);
  add<FourPointHead, FourPointOptions>(registrar, kFourPoint);
  add<GaussianHead, GaussianOptions>(registrar, kGaussian);
  add<PointwiseHead, PointwiseOptions>(registrar, kPointwise);
}

Registry make_head_registry() {
  Registry registry;
  declare_heads(registry);
  registry.add_built_in(register_heads);
  return registry;
}

std::shared_ptr<BoxHead> make_head(std::string_view name, const std::vector<std::string>& options,
                                   const HeadContext& context, Registry& registry) {
  if (context.features < 1 || context.condition < 0 || !context.codec) {
    throw InvalidArgument("make_head: expected at least one feature and a codec");
  }
  require_plugin(HeadKind::kName, name, registry);
  const OptionsInstance instance = registry.find(HeadKind::kName, name).options();
  assign_overrides(instance.fields, options);
  return registry.create<HeadKind>(name, instance, context);
}

std::shared_ptr<BoxHead> make_head(const HeadConfig& config, std::int64_t features,
                                   std::int64_t condition, Registry& registry) {
  return make_head(
      config.name, config.options,
      {.features = features, .condition = condition, .codec = make_codec(config.codec)}, registry);
}

}  // namespace arbox::heads
