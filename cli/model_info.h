#pragma once

#include <string>

namespace arbox::cli {

/// True for an existing file that begins as a model does.
bool is_model_file(const std::string& path);

/// Prints what a model file tells: kind, classes, parameters, configuration, card, and what its
/// confidence boxes are calibrated on. Throws IoError, FormatError.
void print_model(const std::string& path, bool json);

}  // namespace arbox::cli
