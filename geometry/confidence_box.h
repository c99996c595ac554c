#pragma once

#include <span>
#include <vector>

#include "arbox/geometry/quantile_box.h"

/// \file
/// Boxes that hold a chosen share of an object's samples, and what share a box holds or overlaps.
///
/// The quantile box for q = 1 - p holds at least that share where the samples are ordered (theorem
/// 1). Where several faces are unsure at once it holds less: with six faces that each stay inside
/// with probability 0.9, about half of the samples stick out somewhere. Where faces are nearly sure
/// it holds more, for what counts is nearly all of a sample's volume. A confidence box therefore
/// looks for the q whose box holds what it promises of the samples themselves.

namespace arbox::geometry {

/// The share of a box that counts as holding it (paper, section 5.2).
inline constexpr double kHeldIog = 0.95;

/// The part of the samples' weight that `box` holds: samples with more than `min_iog` of their
/// volume inside. Throws InvalidArgument for no samples, bad boxes or weights.
double held_share(const BoxSamples& samples, const Box& box, double min_iog = kHeldIog);

/// The part of the samples' weight that overlaps `box` by an IoU of at least `min_iou`: how likely
/// the box is that good, as far as the samples are true draws of where the object is. Errors as
/// held_share().
double overlapping_share(const BoxSamples& samples, const Box& box, double min_iou);

/// For each p in [0, 1], in the order asked for: the least box that holds samples of weight at
/// least p, on the way from the core of the samples to the box around them all. The way leads
/// through the quantile boxes of q = 63 / 64, 62 / 64 ... 0 and by degrees from each to the next
/// (box_between): one sample more on each face would hold several samples more at once, and boxes
/// of 64 samples would hold about 0.04 more than p. The core itself is the least answer, whatever
/// more than p it holds. For ordered samples the box lies within the quantile box of the largest
/// q = i / 64 that is at most 1 - p.
///
/// It contains the object with probability p as far as the samples are true draws of where the
/// object is; evaluation/confidence_calibration.h makes that a promise about objects.
/// Errors as quantile_boxes(). Cost: that of one call of it, and up to 64 overlaps a sample and 8
/// for each p.
std::vector<ConfidenceBox> confidence_boxes(const BoxSamples& samples, std::span<const double> ps,
                                            const QuantileOptions& options = {});

/// The same for many objects, in parallel; result i belongs to objects[i]. No objects: no results.
std::vector<std::vector<ConfidenceBox>> confidence_boxes(std::span<const BoxSamples> objects,
                                                         std::span<const double> ps,
                                                         const QuantileOptions& options = {});

}  // namespace arbox::geometry
