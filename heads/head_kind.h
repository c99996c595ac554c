#pragma once

#include <torch/version.h>

#include <memory>
#include <string_view>

#include "arbox/base/registry.h"

/// \file
/// Heads as a kind that can be chosen by name and brought by plugins (base/plugin.h). This header
/// needs no LibTorch but its version: a program may know of the kind without loading it.

#undef ARBOX_PLUGIN_LIBTORCH
#define ARBOX_PLUGIN_LIBTORCH TORCH_VERSION

namespace arbox::heads {

class BoxHead;
struct HeadContext;

struct HeadKind {
  static constexpr std::string_view kName = "head";
  using Factory = std::shared_ptr<BoxHead>(const OptionsInstance& options,
                                           const HeadContext& context);
};

/// Makes the kind known: plugins must be built against this LibTorch.
inline void declare_heads(Registry& registry) { registry.declare<HeadKind>(TORCH_VERSION); }

}  // namespace arbox::heads
