#pragma once

#include <CLI/App.hpp>
#include <string>
#include <vector>

#include "arbox/base/options.h"

namespace arbox::cli {

/// Adds a flag for each field of an options struct: `nms.threshold` becomes --nms-threshold VALUE,
/// a switch becomes --flip and --no-flip, a list takes several values or one with commas. Values
/// are checked as those of a configuration file; a violation is wrong usage.
///
/// The struct behind `options` must outlive the parsing. Keys in `without` get no flag.
void add_option_flags(CLI::App& command, const BoundOptions& options,
                      const std::vector<std::string>& without = {});

/// The flag of a key: "nms.max_boxes" gives "--nms-max-boxes".
std::string flag_name(const std::string& key);

}  // namespace arbox::cli
