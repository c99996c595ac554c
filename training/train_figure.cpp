#include "arbox/training/train_figure.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <set>
#include <vector>

#include "arbox/drawing/curves.h"

namespace arbox::training {
namespace {

constexpr std::size_t kPlaces = 300;

double median(std::vector<double> values) {
  std::erase_if(values, [](double value) { return !std::isfinite(value); });
  if (values.empty()) return std::nan("");
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

drawing::Series named(const std::string& name) {
  drawing::Series series;
  series.name = name;
  return series;
}

/// One point for each of at most kPlaces groups of steps.
drawing::Series curve(const std::vector<StepReport>& steps, const std::string& name,
                      const std::function<double(const StepReport&)>& value) {
  drawing::Series series = named(name);
  const std::size_t group = std::max<std::size_t>(1, (steps.size() + kPlaces - 1) / kPlaces);
  for (std::size_t begin = 0; begin < steps.size(); begin += group) {
    const std::size_t end = std::min(steps.size(), begin + group);
    std::vector<double> values;
    for (std::size_t i = begin; i < end; ++i) values.push_back(value(steps[i]));
    series.x.push_back(static_cast<double>(steps[begin].step + steps[end - 1].step) / 2);
    series.y.push_back(median(std::move(values)));
  }
  return series;
}

drawing::Panel panel(const std::string& title, bool logarithmic) {
  return {.title = title, .x = {.label = "step"}, .y = {.logarithmic = logarithmic}};
}

drawing::Panel loss_panel(const std::vector<StepReport>& steps) {
  std::set<std::string> names;
  for (const StepReport& step : steps) {
    for (const auto& [name, ignored] : step.terms) names.insert(name);
  }
  drawing::Panel result = panel("Loss and its terms", true);
  result.series.push_back(curve(steps, "loss", [](const StepReport& step) { return step.loss; }));
  for (const std::string& name : names) {
    result.series.push_back(curve(steps, name, [&](const StepReport& step) {
      const auto term = step.terms.find(name);
      return term == step.terms.end() ? std::nan("") : term->second;
    }));
  }
  return result;
}

drawing::Panel validation_panel(const std::vector<ValidationReport>& validations) {
  std::map<std::string, drawing::Series> series;
  for (const ValidationReport& validation : validations) {
    for (const auto& [name, value] : validation.figures) {
      drawing::Series& line = series.try_emplace(name, named(name)).first->second;
      line.markers = true;
      line.x.push_back(static_cast<double>(validation.step));
      line.y.push_back(value);
    }
  }
  drawing::Panel result = panel("Validation", false);
  for (auto& [name, line] : series) result.series.push_back(std::move(line));
  return result;
}

}  // namespace

drawing::Image draw_training(const TrainHistory& history) {
  std::vector<drawing::Panel> panels = {loss_panel(history.steps)};
  panels.push_back(panel("Gradient norm before clipping", true));
  panels.back().series.push_back(
      curve(history.steps, "", [](const StepReport& step) { return step.gradient_norm; }));
  panels.push_back(panel("Learning rate", true));
  panels.back().series.push_back(
      curve(history.steps, "", [](const StepReport& step) { return step.learning_rate; }));
  if (!history.validations.empty()) panels.push_back(validation_panel(history.validations));
  return drawing::draw_figure(panels, {.columns = 2});
}

}  // namespace arbox::training
