#pragma once

#include <cstdint>
#include <functional>
#include <mutex>
#include <span>
#include <vector>

#include "arbox/heads/internal/packed_network.h"

namespace arbox::heads::internal {

/// Objects of a batch: their features and condition side by side, (objects, width).
struct FeatureRows {
  const float* values = nullptr;
  std::int64_t objects = 0;
  std::int32_t width = 0;
};

/// Rows with different prefixes: the object and the values of the components before.
struct PrefixRows {
  std::span<const std::int32_t> objects;
  /// (objects.size(), previous): de-quantised values, row-major.
  std::span<const float> values;
};

/// Logits of the rows [first, first + count) of one evaluation.
struct LogitBlock {
  std::int64_t first = 0, count = 0;
  const float* values = nullptr;
  std::int32_t columns = 0;  ///< Padded; the padding has no mass.

  const float* row(std::int64_t r) const { return values + r * columns; }
};

/// Evaluates p(component | features, values before) for inference. Work on an object's features is
/// done once, whatever the number of prefixes. A row's logits do not depend on the other rows nor
/// on the number of threads. Use one from one thread at a time.
class ConditionalNetwork {
 public:
  /// Keeps a reference to `network`.
  ConditionalNetwork(const PackedNetwork& network, int threads);

  /// Starts on other objects.
  void set_features(const FeatureRows& features);

  /// Evaluates component `index` for all rows, in blocks, on several threads: `visit` gets every
  /// row once, and its logits while they are in the cache.
  void evaluate(std::int32_t index, const PrefixRows& rows,
                const std::function<void(const LogitBlock&)>& visit);

 private:
  struct Workspace {
    AlignedFloats current, next;
  };

  const float* object_part(std::int32_t index);
  LogitBlock evaluate_block(const PackedComponent& component, const PrefixRows& rows,
                            std::int32_t index, std::int64_t begin, std::int64_t end,
                            Workspace& workspace) const;
  Workspace take_workspace();
  void return_workspace(Workspace workspace);

  const PackedNetwork& network_;
  int threads_;
  std::int64_t most_rows_;
  FeatureRows features_;
  std::vector<AlignedFloats> object_parts_;  // by component, filled on first use
  std::mutex mutex_;
  std::vector<Workspace> workspaces_;
};

}  // namespace arbox::heads::internal
