#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace torch::nn {
class Module;
}

namespace arbox::training {

/// Writes parameters and buffers without anything of the run, floats rounded to float16: what
/// TrainOptions::initial reads, half as large as a model and small enough to be kept with a
/// project. Throws IoError; NumericalError that names a tensor with numbers beyond 65504.
void save_weights(torch::nn::Module& network, const std::filesystem::path& path);

/// Fills a network from such a file, from a model file or from a checkpoint of the same names.
/// Names in `except` (parts, network_state.h) keep their values and need not be in the file. Throws
/// IoError, FormatError that lists what does not fit; nothing is changed then.
void load_weights(torch::nn::Module& network, const std::filesystem::path& path,
                  const std::vector<std::string>& except = {});

/// Moves a network towards the weights of such a file: every fraction becomes (1 - share) of its
/// own and `share` of the file's; whole numbers stay. Of two runs from the same beginning, the mean
/// often errs less than either on data unlike the training's (Wortsman et al., "Model soups", ICML
/// 2022). Throws InvalidArgument for a share outside of [0, 1]; else as load_weights.
void average_weights(torch::nn::Module& network, const std::filesystem::path& path, double share,
                     const std::vector<std::string>& except = {});

}  // namespace arbox::training
