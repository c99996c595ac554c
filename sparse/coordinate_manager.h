#pragma once

#include <memory>
#include <mutex>
#include <tuple>
#include <vector>

#include "arbox/sparse/coordinate_set.h"
#include "arbox/sparse/kernel_geometry.h"
#include "arbox/sparse/kernel_map.h"

namespace arbox::sparse {

/// The pairs between two coordinate sets: what a convolution needs besides features and weights.
struct Connection {
  CoordinateSetPtr inputs, outputs;
  std::shared_ptr<const KernelMap> map;
};

/// Builds coordinate sets and kernel maps once and keeps them, so that all convolutions of one
/// shape on one set share a map, and transposed convolutions find their way back.
///
/// One manager serves one network pass (one batch of scenes); tensors share it. It keeps what it
/// has built until it dies or clear() is called. Safe to use from several threads.
class CoordinateManager {
 public:
  /// threads as in build_kernel_map.
  explicit CoordinateManager(int threads = 0) : threads_(threads) {}

  /// From a set to the outputs of `kernel`: to the set itself if the convolution is submanifold
  /// (or unbounded with stride 1), else to a new set, the same one for every kernel of that
  /// stride on an unbounded lattice.
  Connection convolution(const CoordinateSetPtr& set, const Kernel& kernel);

  /// From a coarse set back to `target`, with each pair that convolution(target, kernel) would
  /// have, turned round (torch's and MinkowskiEngine's transposed, spconv's inverse convolution).
  /// Throws InvalidArgument if the strides do not fit.
  Connection transposed(const CoordinateSetPtr& set, const CoordinateSetPtr& target,
                        const Kernel& kernel);

  /// From a set to all of its children (generated_coordinates).
  Connection generative(const CoordinateSetPtr& set, const Kernel& kernel);

  /// The pairs of each output with itself: a 1x1x1 convolution.
  Connection pointwise(const CoordinateSetPtr& set);

  /// Forgets everything; tensors keep their own sets.
  void clear();
  /// How many kernel maps are kept.
  std::size_t maps() const;

 private:
  enum class Kind { kForward, kTransposed, kGenerative };
  struct Entry {
    Kind kind;
    Kernel kernel;
    CoordinateSetPtr source, target;  // target only if the caller chose it
    Connection connection;
  };
  struct Strided {
    CoordinateSetPtr source;
    Triple stride;
    CoordinateSetPtr outputs;
  };

  const Connection* find(Kind kind, const Kernel& kernel, const CoordinateSetPtr& source,
                         const CoordinateSetPtr& target) const;
  Connection keep(Entry entry);
  CoordinateSetPtr outputs_of(const CoordinateSetPtr& set, const Kernel& kernel);

  int threads_;
  mutable std::mutex mutex_;
  std::vector<Entry> entries_;
  std::vector<Strided> strided_;
};

}  // namespace arbox::sparse
