#pragma once

#include "arbox/base/registry.h"

namespace arbox::cli {

/// Everything that the program knows by name: its built-ins, and the plugins that `--plugin FILE`
/// or require_plugin (base/plugin_loader.h) have brought.
Registry& program_registry();

/// program_registry() with what needs LibTorch, if this installation has it: takes about half a
/// second the first time.
Registry& full_program_registry();

}  // namespace arbox::cli
