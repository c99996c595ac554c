#pragma once

#include <memory>
#include <string>
#include <vector>

#include "arbox/base/option_field.h"
#include "arbox/heads/box_head.h"
#include "arbox/heads/codec_options.h"
#include "arbox/heads/head_kind.h"

namespace arbox::heads {

/// A head and its codec, as a configuration names them.
struct HeadConfig {
  std::string name = "autoregressive";
  /// Changes to the head's options, for example "hidden=[64, 64]"; `arbox config show head/NAME`
  /// lists them.
  std::vector<std::string> options;
  CodecOptions codec;

  template <class Visitor>
  static void describe(Visitor& visitor) {
    visitor.field("name", &HeadConfig::name, {.help = "A built-in head or that of a plugin"});
    visitor.field("options", &HeadConfig::options,
                  {.help = "Changes to the head's options, each KEY=VALUE"});
    visitor.group("codec", &HeadConfig::codec, "How boxes become numbers");
  }
};

/// Adds the built-in heads: autoregressive, discrete, four_point, gaussian, pointwise.
void register_heads(Registrar& registrar);

/// A registry that knows the kind and the built-in heads.
Registry make_head_registry();

/// Builds a head. A name that the registry does not know is looked for among the plugins
/// (base/plugin_loader.h). Throws PluginError for unknown names, ConfigError for options that do
/// not fit, InvalidArgument for a context without features or codec.
std::shared_ptr<BoxHead> make_head(std::string_view name, const std::vector<std::string>& options,
                                   const HeadContext& context, Registry& registry);

/// make_head with the codec of the configuration.
std::shared_ptr<BoxHead> make_head(const HeadConfig& config, std::int64_t features,
                                   std::int64_t condition, Registry& registry);

}  // namespace arbox::heads
