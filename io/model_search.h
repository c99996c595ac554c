#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace arbox::io {

/// The folders where models are looked for by name: those of ARBOX_MODEL_PATH (separated by
/// colons), then share/arbox/models of the installation or the build. Throws ConfigError for a
/// folder that is not absolute.
std::vector<std::filesystem::path> model_folders();

/// The file of a model. `name` is a path if it has a '/' or ends in ".arbox"; else the first
/// NAME.arbox in model_folders(), never in the working directory. Throws IoError if there is none;
/// for a name the message lists the models that there are, and the nearest.
std::filesystem::path find_model(const std::string& name);

}  // namespace arbox::io
