#pragma once

#include "arbox/base/registry.h"

namespace arbox::cli {

/// Everything that the program knows by name: its built-ins, and the plugins that `--plugin FILE`
/// or require_plugin (base/plugin_loader.h) have brought.
Registry& program_registry();

}  // namespace arbox::cli
