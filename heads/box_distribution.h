#pragma once

#include <ATen/core/Tensor.h>

#include <cstdint>
#include <memory>

namespace arbox::heads {

/// Random numbers of a batch of objects. An object's draws depend on (seed, its id, draw,
/// component) alone, not on what else is in the batch.
struct Streams {
  std::uint64_t seed = 0;
  at::Tensor object_ids;  ///< (N) int64.
};

/// K boxes for each of N objects.
struct Draws {
  at::Tensor boxes;        ///< (N, K, 10), metres, in the frame of the references.
  at::Tensor log_density;  ///< (N, K) per unit component volume; undefined where Measure::kNone.
  at::Tensor components;   ///< (N, K, D); undefined for heads outside of the codec's space.
};

/// How the most likely boxes are searched.
struct ModeOptions {
  /// Prefixes that a beam search keeps; also the most boxes that come back. At least 1.
  int beam_width = 16;
  /// Standard deviation, in bins, of the kernel that each conditional distribution over bins is
  /// smoothed with before it is searched; 0 to 1000. At 0 the most likely bins win, as in the
  /// paper. The highest bin of a wide distribution is an accident of its 512 outputs; smoothed, the
  /// place with most probability around it wins. Heads without bins are smooth as they are.
  double smoothing = 0.0;
};

/// Whether a head's likelihood is a density over components (bin mass divided by bin width, so that
/// heads compare) or does not exist.
enum class Measure { kNone, kDensity };

/// The posteriors over boxes of N objects (paper, sections 3 and 4). Lazy: work happens when asked.
/// Knows its codec and references and answers in boxes. Everything runs without gradient.
class BoxDistribution {
 public:
  virtual ~BoxDistribution();

  virtual std::int64_t size() const = 0;
  virtual Measure measure() const = 0;

  /// The most likely boxes by beam search (section 4.1), best first; K <= beam_width. Vectors that
  /// decode to the same physical box may both appear; each has the density of its vector alone, the
  /// smoothed density where options.smoothing is not 0.
  virtual Draws mode(const ModeOptions& options) const = 0;

  /// `count` independent draws of each object. Heads without a distribution repeat their one box.
  virtual Draws sample(int count, const Streams& streams, double temperature = 1.0) const = 0;

  /// (N, 10): mean of each component (circular where the component is), decoded.
  virtual at::Tensor mean() const = 0;

  /// boxes (N, 10) -> (N): log density, summed over the equivalent vectors of each physical box.
  /// Throws NotAvailable where measure() is kNone.
  virtual at::Tensor log_density(const at::Tensor& boxes) const = 0;

  /// The objects of `index` (int64, (K)), for instance the survivors of suppression.
  virtual std::unique_ptr<BoxDistribution> select(const at::Tensor& index) const = 0;

  /// p(rest | size, h) with the size (N, 3) metres fixed, one permutation as given. Throws
  /// NotAvailable if the codec's order does not put the size first.
  virtual std::unique_ptr<BoxDistribution> given_sizes(const at::Tensor& sizes) const = 0;

  /// sizes (N, 3) metres -> (N): log density of the size components, -infinity outside of their
  /// ranges; with given_sizes() it makes the joint density. Throws NotAvailable where given_sizes()
  /// does, and where measure() is kNone.
  virtual at::Tensor log_size_density(const at::Tensor& sizes) const;
};

/// (N): entropy of each object's vectors, nats, estimated from `draws` draws as the mean of
/// -log density. Throws NotAvailable where measure() is kNone.
at::Tensor entropy(const BoxDistribution& distribution, int draws, const Streams& streams);

/// \name Checks of arguments that every distribution makes; they throw InvalidArgument.
/// @{
void require_mode_options(const ModeOptions& options);
void require_draws(int count, const Streams& streams, double temperature, std::int64_t objects);
void require_sizes(const at::Tensor& sizes, std::int64_t objects);
/// @}

}  // namespace arbox::heads
