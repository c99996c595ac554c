#pragma once

#include <Eigen/Core>
#include <span>
#include <string>
#include <vector>

#include "arbox/base/option_field.h"
#include "arbox/geometry/box.h"
#include "arbox/geometry/known_size.h"
#include "arbox/heads/box_distribution.h"

/// \file
/// Boxes of objects whose size is known, though not which object has which (paper, section 4.4 and
/// docs/box-distributions.md).

namespace arbox::heads {

using geometry::KnownSize;

struct ConditioningOptions {
  /// Beams of each search: one search for every known size and distinct order of its extents.
  int beam_width = 16;
  /// ModeOptions::smoothing of each search.
  double smoothing = 0.0;
  /// What is compared: "given_size", p(rest | size, h) as in the paper, averaged over the orders of
  /// the extents, or "joint", p(size | h) p(rest | size, h), summed over them, which also asks how
  /// likely the size is.
  std::string score = "given_size";
  /// "any": the numbers of a known size are its extents in any order; "given": length, width and
  /// height.
  std::string orders = "any";
  /// Beams are the same physical box if every corner of one is this close to a corner of the other,
  /// as a part of the diagonal. The default is about half a bin of 512 for rotations.
  double same_box = 0.005;

  template <class Visitor>
  static void describe(Visitor& visitor) {
    visitor.field("beam_width", &ConditioningOptions::beam_width,
                  {.help = "Beams of each search", .low = 1, .high = 65536});
    visitor.field("smoothing", &ConditioningOptions::smoothing,
                  {.help = "Standard deviation of the kernel that densities are smoothed with",
                   .unit = "bins",
                   .low = 0,
                   .high = 1000});
    visitor.field(
        "score", &ConditioningOptions::score,
        {.help = "Density that known sizes are compared by", .choices = {"given_size", "joint"}});
    visitor.field(
        "orders", &ConditioningOptions::orders,
        {.help = "Orders of a known size's extents that are tried", .choices = {"any", "given"}});
    visitor.field("same_box", &ConditioningOptions::same_box,
                  {.help = "Distance of corners up to which beams are the same box",
                   .unit = "diagonals",
                   .low = 0,
                   .high = 0.1});
  }
};

/// The best box of one known size.
struct SizedBox {
  geometry::Box box;
  /// The densities of the beams that are this box, of any order of the extents, put together (see
  /// ConditioningOptions::score), log; -infinity, with the default box, if there is no finite beam.
  double log_density = 0.0;
};

/// What an object is, given the known sizes.
struct ConditionedBox {
  /// Index of the known size of the most likely box; ties go to the earlier one.
  std::size_t known_size = 0;
  geometry::Box box;
  double log_density = 0.0;
  /// Lead of its log density over the best box of any other known size: at least 0, infinite
  /// without another.
  double margin = 0.0;
  std::vector<SizedBox> by_size;  ///< One a known size.
};

/// b* = argmax over known sizes d of max over b of p(b | d, h), for each object. The size of a
/// result's box is exactly one of the orders of the known size.
///
/// No objects: no results. Errors: InvalidArgument for no known sizes or extents that are not
/// finite and above zero, ConfigError for bad options, NotAvailable if the head cannot be
/// conditioned, for instance because its codec does not predict the size first.
/// Cost: a beam search for each size and order (6 where the extents differ and may have any).
std::vector<ConditionedBox> given_known_sizes(const BoxDistribution& distribution,
                                              std::span<const KnownSize> known,
                                              const ConditioningOptions& options = {});

/// Why a distribution does not tell how likely sizes are and the boxes of each; empty if it does.
std::string why_not_conditioned(const BoxDistribution& distribution);

/// (N): log of the sum over the distinct orders of `extents` of the density of that size, for each
/// object.
std::vector<double> log_density_of_size(const BoxDistribution& distribution,
                                        const Eigen::Vector3d& extents);

/// The size that all objects of a scene have, where all are of one kind.
struct CommonSize {
  std::size_t candidate = 0;
  /// Sum over the objects of log_density_of_size, one a candidate.
  std::vector<double> log_densities;
  /// Lead over the next candidate that is another size; infinite without one.
  double margin = 0.0;
};

/// The candidate that is most likely over all objects together; ties go to the earlier one.
/// Errors as given_known_sizes; no objects make every candidate equally likely.
CommonSize common_size(const BoxDistribution& distribution,
                       std::span<const Eigen::Vector3d> candidates);

/// Candidates for common_size: sizes of `count` draws of each object, object by object. Draws that
/// are not finite are left out.
std::vector<Eigen::Vector3d> draw_sizes(const BoxDistribution& distribution, int count,
                                        const Streams& streams);

}  // namespace arbox::heads
