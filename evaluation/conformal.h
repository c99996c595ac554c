#pragma once

#include <cstdint>
#include <span>

/// \file
/// Split conformal prediction (Vovk et al., 2005; Papadopoulos et al., 2002; Lei et al., 2018).
///
/// A nonconformity score says how far a prediction had to be widened until it was right. If the
/// scores of n calibration objects and of a new object are exchangeable, then the new object's
/// score is at most the threshold below with a probability of at least p, whatever the predictor
/// and however few the objects. Exchangeability is an assumption about the data: a threshold
/// calibrated on one city, sensor or detector promises nothing for another. The promise holds on
/// average over objects of the class, not for each kind of object within it.

namespace arbox::evaluation {

/// Rank, from 1, of the calibration score that is the threshold for probability p among n scores:
/// ceil((n + 1) p), the finite-sample correction. A rank above n means that n objects are too few
/// to promise p. Throws InvalidArgument unless 0 < p < 1 and n >= 0.
std::int64_t conformal_rank(std::int64_t n, double p);

/// Objects that a class needs before p can be promised: the least n with conformal_rank(n, p) <= n.
std::int64_t conformal_objects_needed(double p);

/// The score of rank conformal_rank(n, p), from the smallest up; infinity if the scores are too
/// few.
///
/// Scores may be infinite (never right) and in any order. Throws InvalidArgument for NaN and for p
/// outside of (0, 1). Cost O(n).
double conformal_threshold(std::span<const double> scores, double p);

}  // namespace arbox::evaluation
