#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace arbox::heads::internal {

/// Smooths the probabilities of bins with three box filters in a row, nearly a Gaussian, in a time
/// that does not depend on its width. Keeps its memory; one a thread.
class RowSmoother {
 public:
  /// `standard_deviation` in bins, at least 0. That of the filters is as near to it as odd widths
  /// allow; below 0.5 bins nothing is smoothed.
  explicit RowSmoother(double standard_deviation);

  /// Standard deviation of the filters, bins.
  double standard_deviation() const;

  /// Log probabilities in, those of the smoothed probabilities out. What goes over the ends of a
  /// row that is not circular is lost. A row that is not finite throughout may come out as
  /// anything.
  void smooth(std::span<float> log_probability, bool circular);

 private:
  std::int64_t reach() const;

  std::int64_t half_widths_[3];
  std::vector<double> values_, sums_;
};

}  // namespace arbox::heads::internal
