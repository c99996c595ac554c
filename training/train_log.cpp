#include "arbox/training/train_log.h"

#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>
#include <sstream>
#include <utility>

#include "arbox/base/error.h"
#include "arbox/io/file.h"
#include "arbox/training/durable_file.h"

namespace arbox::training {
namespace {

using Json = nlohmann::ordered_json;

Json line_of(const StepReport& report) {
  return {{"step", report.step},
          {"steps", report.steps},
          {"epoch", report.epoch},
          {"loss", report.loss},
          {"terms", report.terms},
          {"learning_rate", report.learning_rate},
          {"momentum", report.momentum},
          {"gradient_norm", report.gradient_norm},
          {"skipped", report.skipped},
          {"seconds", report.seconds},
          {"scenes_per_second", report.scenes_per_second}};
}

Json line_of(const ValidationReport& report) {
  return {{"validation", report.step}, {"figures", report.figures}, {"seconds", report.seconds}};
}

double number(const Json& value) {
  return value.is_number() ? value.get<double>() : std::numeric_limits<double>::quiet_NaN();
}

std::map<std::string, double> numbers(const Json& values) {
  std::map<std::string, double> result;
  for (const auto& [name, value] : values.items()) result[name] = number(value);
  return result;
}

StepReport step_of(const Json& line) {
  StepReport report;
  report.step = line.at("step").get<std::int64_t>();
  report.steps = line.at("steps").get<std::int64_t>();
  report.epoch = number(line.at("epoch"));
  report.loss = number(line.at("loss"));
  report.terms = numbers(line.at("terms"));
  report.learning_rate = number(line.at("learning_rate"));
  report.momentum = number(line.at("momentum"));
  report.gradient_norm = number(line.at("gradient_norm"));
  report.skipped = line.at("skipped").get<bool>();
  report.seconds = number(line.at("seconds"));
  report.scenes_per_second = number(line.at("scenes_per_second"));
  return report;
}

/// False for a line that is not one of a log.
bool read_line(const std::string& text, TrainHistory& history) {
  try {
    const Json line = Json::parse(text);
    if (line.contains("validation")) {
      history.validations.push_back({line.at("validation").get<std::int64_t>(),
                                     numbers(line.at("figures")), number(line.at("seconds"))});
    } else {
      history.steps.push_back(step_of(line));
    }
    return true;
  } catch (const nlohmann::json::exception&) {
    return false;
  }
}

}  // namespace

TrainHistory read_train_log(const std::filesystem::path& file) {
  std::istringstream content(io::read_file(file));
  TrainHistory history;
  for (std::string line; std::getline(content, line);) read_line(line, history);
  return history;
}

TrainLog::TrainLog(std::filesystem::path file, std::int64_t step, std::int64_t validated)
    : file_(std::move(file)) {
  std::string kept;
  if (std::filesystem::exists(file_)) {
    std::istringstream content(io::read_file(file_));
    for (std::string line; std::getline(content, line);) {
      TrainHistory found;
      if (!read_line(line, found)) break;
      if (!found.steps.empty() && found.steps[0].step > step) break;
      if (!found.validations.empty() && found.validations[0].step > validated) break;
      read_line(line, history_);
      kept += line + "\n";
    }
  }
  write_durably(file_, kept);
}

void TrainLog::write(const StepReport& report) {
  append(line_of(report).dump());
  history_.steps.push_back(report);
}

void TrainLog::write(const ValidationReport& report) {
  append(line_of(report).dump());
  history_.validations.push_back(report);
}

void TrainLog::append(const std::string& line) {
  std::ofstream stream(file_, std::ios::binary | std::ios::app);
  stream << line + "\n" << std::flush;
  if (!stream) throw IoError(file_.string() + ": cannot be written");
}

}  // namespace arbox::training
