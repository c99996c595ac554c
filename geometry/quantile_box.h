#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "arbox/base/option_field.h"
#include "arbox/geometry/box.h"

/// \file
/// Occupancy and quantile boxes of sampled boxes (Liu et al., ECCV 2022, sections 4.2 and 4.3,
/// appendix B). The samples may come from any source: a head's distribution, or an ensemble of
/// other detectors.
///
/// The occupancy O(x) of a point is the weight of the samples that hold it. The occupancy quantile
/// Q(q) is the set of points with O(x) > q, and the quantile box the smallest box around it: q = 0
/// gives a box around every sample, a high q the core that nearly all samples agree on. Where of
/// any two samples one lies inside the other (an ordered distribution), the quantile box contains
/// samples of weight at least 1 - q (theorem 1); elsewhere it holds less, the more faces are unsure
/// at once (confidence_box.h goes on until it holds its share). docs/quantile-boxes.md explains
/// this to users.
///
/// A point counts as inside a sample if it is within 1e-9 m of it (plus 4e-15 of its coordinates),
/// so that samples which share a face agree on it whatever the rounding.

namespace arbox::geometry {

/// The minimum-volume box over the points whose occupancy is above q.
struct QuantileBox {
  double q = 0.0;
  Box box;
  /// True if no point had an occupancy above q, so that `box` came from the documented fallback.
  bool fallback = false;
};

/// A box that contains the object with probability p.
struct ConfidenceBox {
  double p = 0.0;
  Box box;
};

/// Draws from one object's distribution over boxes.
struct BoxSamples {
  /// At least one valid box.
  std::span<const Box> boxes;
  /// Relative weights, one a box, finite, at least 0 and not all 0. Empty means equal weights.
  std::span<const double> weights = {};
  /// Names the object's random numbers: its result depends on (seed, object) and not on what else
  /// is in the batch.
  std::uint64_t object = 0;
};

struct QuantileOptions {
  /// Points drawn in every sample to find Q(q) among, besides the corners.
  int points_per_box = 64;
  /// How they are drawn. `uniform`: independently. `stratified`: one in each cell of the largest
  /// n x n x n grid that has at most that many cells, the rest uniformly. `jittered_grid`: the
  /// paper's code, an n x n x n grid from face to face moved by up to 1 / n of a half size, so that
  /// points lie up to 1 / n outside; points_per_box must be a cube of at least 8.
  std::string placement = "stratified";
  /// Whether the 8 corners of every sample are points too. Without them the faces are never
  /// reached and theorem 1 does not hold.
  bool corners = true;
  /// Searches rotations beyond those of the samples; the box never grows by it. Samples that are
  /// all yaw-only keep a yaw-only box, of the least volume over all yaws.
  bool refine = false;
  std::uint64_t seed = 0;
  /// 0 means default_threads(). The result does not depend on it.
  int threads = 0;

  template <class Visitor>
  static void describe(Visitor& visitor) {
    visitor.field(
        "points_per_box", &QuantileOptions::points_per_box,
        {.help = "Points drawn in every box sample", .unit = "points", .low = 0, .high = 1e6});
    visitor.field("placement", &QuantileOptions::placement,
                  {.help = "How the points are drawn",
                   .choices = {"uniform", "stratified", "jittered_grid"}});
    visitor.field("corners", &QuantileOptions::corners,
                  {.help = "Use the corners of every sample as points too"});
    visitor.field("refine", &QuantileOptions::refine,
                  {.help = "Search rotations beyond those of the samples"});
    visitor.field("seed", &QuantileOptions::seed, {.help = "Seed of the points"});
    visitor.field("threads", &QuantileOptions::threads,
                  {.help = "Threads; 0 means the program's default", .low = 0, .high = 1024});
  }
};

/// O(x): the part of the samples' weight whose boxes hold `point`, in [0, 1].
/// Throws InvalidArgument for no samples, bad boxes or weights, or a point that is not finite.
double occupancy(const BoxSamples& samples, const Eigen::Vector3d& point);
double occupancy(std::span<const Box> samples, const Eigen::Vector3d& point);

/// The points at which quantile_boxes() asks for the occupancy: those of each sample of non-zero
/// weight in turn, then the corners of each distinct one.
std::vector<Eigen::Vector3d> occupancy_points(const BoxSamples& samples,
                                              const QuantileOptions& options = {});

/// Q(q): those of occupancy_points() with an occupancy above q.
std::vector<Eigen::Vector3d> occupancy_quantile(const BoxSamples& samples, double q,
                                                const QuantileOptions& options = {});

/// The quantile box for each q in [0, 1], in the order asked for (paper, algorithm 1, with
/// d = max - min): the smallest of the boxes around Q(q) that have the rotation of a sample of
/// non-zero weight; of equally small ones that of the first sample.
///
/// Fallback: if Q(q) is empty, or flat so that its box would have no volume, the box is that of the
/// highest q' < q for which it has one, and `fallback` is true. If there is none either (no corners
/// and next to no points), it is the first of the samples with the largest weight. The result is
/// always a valid box.
///
/// Errors: InvalidArgument that names the object and row for no samples, bad boxes or weights, a q
/// out of [0, 1] or bad options.
/// Cost: O(samples^2 points_per_box), whatever the number of qs; equal samples count once.
std::vector<QuantileBox> quantile_boxes(std::span<const Box> samples, std::span<const double> qs,
                                        const QuantileOptions& options = {});
std::vector<QuantileBox> quantile_boxes(const BoxSamples& samples, std::span<const double> qs,
                                        const QuantileOptions& options = {});

/// The same for many objects, in parallel; result i belongs to objects[i]. No objects: no results.
std::vector<std::vector<QuantileBox>> quantile_boxes(std::span<const BoxSamples> objects,
                                                     std::span<const double> qs,
                                                     const QuantileOptions& options = {});

/// U = 1 - IoU of two quantile boxes of one object, in [0, 1]: how far apart the core and the hull
/// of its distribution are (paper, section 4.3; it takes q = 0.2 and 0.8).
double quantile_uncertainty(const Box& first, const Box& second);

/// G = product of the standard deviations of the three sizes over the product of their means: the
/// measure that the paper compares U with. Means must be above zero, deviations at least zero.
double gaussian_uncertainty(const Eigen::Vector3d& size_deviation,
                            const Eigen::Vector3d& size_mean);

/// The same with the weighted mean and (population) deviation of the samples' sizes.
double gaussian_uncertainty(const BoxSamples& samples);

}  // namespace arbox::geometry
