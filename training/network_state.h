#pragma once

#include <ATen/core/Tensor.h>

#include <map>
#include <string>
#include <vector>

namespace torch::nn {
class Module;
}

namespace arbox::training {

using NamedTensors = std::map<std::string, at::Tensor>;

/// Whether `name` is `part` or lies in it: "roi_head" holds "roi_head.shared_fc_layer.0.weight".
bool in_part(const std::string& name, const std::string& part);

/// Puts a network into training mode but for its frozen parts, which keep their weights and the
/// statistics of their batch norms. Throws ConfigError for a part that the network does not have.
void set_training(torch::nn::Module& network, const std::vector<std::string>& frozen);

/// Parameters that are trained, by name in the network's order, the same tensors.
std::vector<std::pair<std::string, at::Tensor>> trained_parameters(torch::nn::Module& network);

/// All parameters and buffers by name, the same tensors.
NamedTensors network_tensors(torch::nn::Module& network);

/// Copies `from` into tensors of the same names. Throws FormatError, beginning with `source`, that
/// lists names that only one side has and shapes or types that differ; nothing is copied then.
void copy_tensors(const NamedTensors& to, const NamedTensors& from, const std::string& source);

/// Copies of the running statistics, so that a step can be undone.
class BufferBackup {
 public:
  explicit BufferBackup(torch::nn::Module& network);
  /// Remembers the buffers as they are now.
  void save();
  /// Sets them back.
  void restore();

 private:
  std::vector<at::Tensor> buffers_, copies_;
};

}  // namespace arbox::training
