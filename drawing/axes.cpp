#include <algorithm>
#include <cmath>
#include <cstdio>

#include "arbox/drawing/internal/axes.h"

namespace arbox::drawing {

std::vector<double> nice_ticks(double low, double high, int count) {
  if (!(low < high) || !std::isfinite(high - low)) return {};
  const double rough = (high - low) / std::max(1, count);
  const double power = std::pow(10.0, std::floor(std::log10(rough)));
  double step = 10.0 * power;
  for (const double factor : {5.0, 2.5, 2.0, 1.0}) {
    if (factor * power >= 0.999 * rough) step = factor * power;
  }
  std::vector<double> ticks;
  for (double i = std::ceil(low / step - 1e-6); i * step <= high + 1e-6 * step; ++i) {
    ticks.push_back(i == 0.0 ? 0.0 : i * step);
    if (ticks.size() > 100) return {};
  }
  return ticks;
}

std::vector<double> logarithmic_ticks(double low, double high) {
  std::vector<double> ticks, finer;
  if (!(low > 0.0) || !(low < high) || !std::isfinite(high)) return ticks;
  for (int power = static_cast<int>(std::floor(std::log10(low))); power <= std::log10(high) + 1e-9;
       ++power) {
    for (const double factor : {1.0, 2.0, 5.0}) {
      const double value = factor * std::pow(10.0, power);
      if (value < low * (1 - 1e-9) || value > high * (1 + 1e-9)) continue;
      finer.push_back(value);
      if (factor == 1.0) ticks.push_back(value);
    }
  }
  return ticks.size() >= 3 ? ticks : finer;
}

double nice_below(double value) {
  const double power = std::pow(10.0, std::floor(std::log10(value)));
  for (const double factor : {5.0, 2.0}) {
    if (factor * power <= value) return factor * power;
  }
  return power;
}

std::string short_number(double value, int digits) {
  char buffer[64];
  std::snprintf(buffer, sizeof buffer, "%.*f", digits, value);
  std::string text = buffer;
  if (text.find('.') != std::string::npos) {
    text.erase(text.find_last_not_of('0') + 1);
    if (text.back() == '.') text.pop_back();
  }
  if (text == "-0") text = "0";
  // A real minus sign is as wide as a digit.
  if (text.front() == '-') text.replace(0, 1, "\u2212");
  return text;
}

std::vector<std::string> tick_texts(const std::vector<double>& ticks) {
  double largest = 0.0;
  for (const double tick : ticks) largest = std::max(largest, std::abs(tick));
  const bool powers = largest >= 1e6 || (largest > 0.0 && largest < 1e-3);
  std::size_t decimals = 0;
  std::vector<std::string> texts;
  for (const double tick : ticks) {
    if (powers) {
      char buffer[32];
      std::snprintf(buffer, sizeof buffer, "%.3g", tick);
      texts.push_back(buffer);
      continue;
    }
    const std::string text = short_number(tick, 6);
    const std::size_t point = text.find('.');
    if (point != std::string::npos) decimals = std::max(decimals, text.size() - point - 1);
    texts.push_back(text);
  }
  if (powers || decimals == 0) return texts;
  for (std::string& text : texts) {
    const std::size_t point = text.find('.');
    const std::size_t has = point == std::string::npos ? 0 : text.size() - point - 1;
    if (point == std::string::npos) text += '.';
    text.append(decimals - has, '0');
  }
  return texts;
}

}  // namespace arbox::drawing
