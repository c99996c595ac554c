#pragma once

#include <string>
#include <vector>

namespace arbox::drawing {

/// Numbers for an axis' ticks: multiples of 1, 2, 2.5 or 5 times a power of ten within [low, high],
/// about `count` of them. Empty unless low < high and both are finite.
std::vector<double> nice_ticks(double low, double high, int count);

/// Powers of ten within [low, high]; with 2 and 5 times them where there are fewer than three.
std::vector<double> logarithmic_ticks(double low, double high);

/// The next number of the form 1, 2 or 5 times a power of ten that is not above value > 0.
double nice_below(double value);

/// The ticks as text with equally many decimals, or as powers where they are very large or small.
std::vector<std::string> tick_texts(const std::vector<double>& ticks);

/// A number with up to `digits` decimals, without trailing zeros.
std::string short_number(double value, int digits);

}  // namespace arbox::drawing
