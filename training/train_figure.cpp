#include "arbox/training/train_figure.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "arbox/drawing/curves.h"

namespace arbox::training {
namespace {

constexpr std::size_t kPlaces = 300;
constexpr std::size_t kLines = 4;
constexpr std::size_t kFewPanels = 6;

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

/// The loss, then its terms, a few lines in each panel so that they can be told apart.
void add_loss_panels(const std::vector<StepReport>& steps, std::vector<drawing::Panel>& panels) {
  std::set<std::string> names;
  for (const StepReport& step : steps) {
    for (const auto& [name, ignored] : step.terms) names.insert(name);
  }
  panels.push_back(panel("Loss", true));
  panels.back().series.push_back(
      curve(steps, "", [](const StepReport& step) { return step.loss; }));
  std::size_t lines = kLines;
  for (const std::string& name : names) {
    if (lines == kLines) {
      panels.push_back(panel("Its terms", true));
      lines = 0;
    }
    panels.back().series.push_back(curve(steps, name, [&](const StepReport& step) {
      const auto term = step.terms.find(name);
      return term == step.terms.end() ? std::nan("") : term->second;
    }));
    ++lines;
  }
}

/// Panel and line of a figure: "gaussian: Car found" is a line of "Car found", where heads compare;
/// "Car found" a line of "Car".
std::pair<std::string, std::string> place_of(const std::string& figure) {
  const std::size_t colon = figure.find(": ");
  if (colon != std::string::npos) return {figure.substr(colon + 2), figure.substr(0, colon)};
  const std::size_t space = figure.find(' ');
  if (space != std::string::npos) return {figure.substr(0, space), figure.substr(space + 1)};
  return {"", figure};
}

void add_validation_panels(const std::vector<ValidationReport>& validations,
                           std::vector<drawing::Panel>& panels) {
  std::map<std::string, std::map<std::string, drawing::Series>> series;
  for (const ValidationReport& validation : validations) {
    for (const auto& [figure, value] : validation.figures) {
      const auto [title, name] = place_of(figure);
      drawing::Series& line = series[title].try_emplace(name, named(name)).first->second;
      line.markers = true;
      line.x.push_back(static_cast<double>(validation.step));
      line.y.push_back(value);
    }
  }
  for (auto& [title, lines] : series) {
    panels.push_back(panel(title.empty() ? "Validation" : "Validation: " + title, false));
    for (auto& [name, line] : lines) panels.back().series.push_back(std::move(line));
  }
}

}  // namespace

drawing::Image draw_training(const TrainHistory& history) {
  std::vector<drawing::Panel> panels;
  add_loss_panels(history.steps, panels);
  panels.push_back(panel("Gradient norm before clipping", true));
  panels.back().series.push_back(
      curve(history.steps, "", [](const StepReport& step) { return step.gradient_norm; }));
  panels.push_back(panel("Learning rate", true));
  panels.back().series.push_back(
      curve(history.steps, "", [](const StepReport& step) { return step.learning_rate; }));
  add_validation_panels(history.validations, panels);
  return drawing::draw_figure(panels, {.columns = panels.size() > kFewPanels ? 3 : 2});
}

}  // namespace arbox::training
