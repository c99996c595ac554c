#pragma once

#include "arbox/base/plugin_abi.h"
#include "arbox/base/registry.h"

/// \file
/// What the author of a plugin includes. One library `libarbox_<kind>_<name>.so` is one plugin:
///
///     void register_mine(arbox::Registrar& registrar) {
///       registrar.add<DetectorKind, MyOptions>("mine", "What it does", [](const MyOptions&
///       options) {
///         return std::make_unique<MyDetector>(options);
///       });
///     }
///     ARBOX_PLUGIN("detector", "mine", "1.0.0", "Apache-2.0", register_mine)
///
/// Nothing happens at load but what register_mine does. `arbox plugins check FILE` tells whether it
/// fits. Kinds that pass tensors define ARBOX_PLUGIN_LIBTORCH to LibTorch's version in the header
/// that declares the kind.

/// Exports the two C functions of a plugin.
#define ARBOX_PLUGIN(kind, name, version, licence, register_function)      \
  ARBOX_PLUGIN_WITH_BUILD(kind, name, version, licence, register_function, \
                          ::arbox::build_fingerprint(ARBOX_PLUGIN_LIBTORCH))

/// As ARBOX_PLUGIN with a fingerprint of the caller's choice, for tests of the refusal.
#define ARBOX_PLUGIN_WITH_BUILD(kind, name, version, licence, register_function, fingerprint)     \
  extern "C" __attribute__((visibility("default"))) const ArboxPluginInfo* arbox_plugin_info() {  \
    static constexpr ArboxPluginInfo kInfo = {                                                    \
        sizeof(ArboxPluginInfo), ::arbox::kPluginAbi, kind, name, version, licence, fingerprint}; \
    return &kInfo;                                                                                \
  }                                                                                               \
  extern "C" __attribute__((visibility("default"))) void arbox_plugin_register(                   \
      ::arbox::Registrar& registrar) {                                                            \
    register_function(registrar);                                                                 \
  }

#if !defined(ARBOX_PLUGIN_LIBTORCH)
#define ARBOX_PLUGIN_LIBTORCH ""
#endif
