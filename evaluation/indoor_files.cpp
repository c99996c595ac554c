#include "arbox/evaluation/indoor_files.h"

#include <algorithm>
#include <map>
#include <optional>
#include <string_view>
#include <utility>

#include "arbox/base/error.h"
#include "arbox/io/box_table.h"
#include "arbox/io/detection_json.h"

namespace arbox::evaluation {
namespace {

namespace fs = std::filesystem;

enum class Role { kTruth, kPredictions };
enum class Form { kJson, kTable, kVotenet };

using Boxes = std::vector<LabeledBox>;
using Scenes = std::map<std::string, Boxes>;

std::string_view votenet_ending(Role role) {
  return role == Role::kTruth ? "_gt_map_cls.txt" : "_pred_map_cls.txt";
}

/// The form of one file, or nothing for a file that is none of them.
std::optional<Form> form_of(const fs::path& file, Role role) {
  const std::string extension = file.extension().string();
  if (extension == ".json" || extension == ".jsonl") return Form::kJson;
  if (extension == ".csv") return Form::kTable;
  if (file.filename().string().ends_with(votenet_ending(role))) return Form::kVotenet;
  return std::nullopt;
}

void add_scene(Scenes& scenes, const std::string& name, Boxes boxes, const fs::path& file) {
  if (!scenes.emplace(name, std::move(boxes)).second) {
    throw FormatError(file.string() + ": scene '" + name + "' stands twice");
  }
}

void read_json(Scenes& scenes, const fs::path& file) {
  const auto scans = io::read_detections_json(file);
  for (const io::ScanDetections& scan : scans) {
    const std::string source = fs::path(scan.source).stem().string();
    const std::string name = source.empty() ? file.stem().string() : source;
    Boxes boxes;
    for (const geometry::Detection& detection : scan.detections) {
      if (detection.label.empty()) {
        throw FormatError(file.string() + ": scene '" + name +
                          "': expected a class with every box");
      }
      boxes.push_back({.label = detection.label, .box = detection.box, .score = detection.score});
    }
    add_scene(scenes, name, std::move(boxes), file);
  }
}

void read_table(Scenes& scenes, const fs::path& file, Role role) {
  const io::BoxTable table = io::read_box_table(file);
  const auto require_column = [&](std::size_t rows, const char* name) {
    if (rows != table.boxes.size()) {
      throw FormatError(file.string() + ": expected a header with the column " + name);
    }
  };
  require_column(table.classes.size(), "class");
  if (role == Role::kPredictions) require_column(table.scores.size(), "score");
  Boxes boxes;
  for (std::size_t row = 0; row < table.boxes.size(); ++row) {
    boxes.push_back({.label = table.classes[row],
                     .box = table.boxes[row],
                     .score = table.scores.empty() ? 0.0 : table.scores[row]});
  }
  add_scene(scenes, file.stem().string(), std::move(boxes), file);
}

void read_file(Scenes& scenes, const fs::path& file, Form form, Role role,
               const std::vector<std::string>& classes) {
  switch (form) {
    case Form::kJson:
      return read_json(scenes, file);
    case Form::kTable:
      return read_table(scenes, file, role);
    case Form::kVotenet: {
      const std::string name = file.filename().string();
      return add_scene(scenes, name.substr(0, name.size() - votenet_ending(role).size()),
                       read_votenet_boxes(file, role == Role::kPredictions, classes), file);
    }
  }
}

std::vector<std::pair<fs::path, Form>> files_in(const fs::path& folder, Role role) {
  std::vector<std::pair<fs::path, Form>> files;
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (const auto form = form_of(entry.path(), role)) files.emplace_back(entry.path(), *form);
  }
  if (files.empty()) {
    throw IoError(folder.string() + ": holds no *.json, *.jsonl, *.csv or *" +
                  std::string(votenet_ending(role)));
  }
  std::sort(files.begin(), files.end());
  for (const auto& [file, form] : files) {
    if (form != files[0].second) {
      throw IoError(folder.string() + ": expected files of one kind, got " +
                    files[0].first.filename().string() + " and " + file.filename().string());
    }
  }
  return files;
}

std::vector<std::pair<fs::path, Form>> files_of(const fs::path& path, Role role) {
  if (fs::is_directory(path)) return files_in(path, role);
  if (!fs::exists(path)) throw IoError(path.string() + ": no such file or folder");
  if (form_of(path, role) != Form::kJson) {
    throw IoError(path.string() +
                  ": expected *.json, *.jsonl or a folder, got a file of another name");
  }
  return {{path, Form::kJson}};
}

Scenes read_scenes(const fs::path& path, Role role, const std::vector<std::string>& classes,
                   const std::function<void()>& read) {
  Scenes scenes;
  for (const auto& [file, form] : files_of(path, role)) {
    read_file(scenes, file, form, role, classes);
    if (read) read();
  }
  return scenes;
}

}  // namespace

std::int64_t count_indoor_files(const fs::path& truth, const fs::path& predictions) {
  return static_cast<std::int64_t>(files_of(truth, Role::kTruth).size() +
                                   files_of(predictions, Role::kPredictions).size());
}

std::vector<IndoorScene> read_indoor_scenes(const fs::path& truth, const fs::path& predictions,
                                            const std::vector<std::string>& classes,
                                            const std::function<void()>& read) {
  Scenes true_boxes = read_scenes(truth, Role::kTruth, classes, read);
  Scenes predicted_boxes = read_scenes(predictions, Role::kPredictions, classes, read);
  std::vector<IndoorScene> scenes;
  for (auto& [name, boxes] : true_boxes) {
    const auto predicted = predicted_boxes.find(name);
    if (predicted == predicted_boxes.end()) {
      throw FormatError(predictions.string() + ": no predictions of scene '" + name +
                        "'; write an empty list where nothing was found");
    }
    scenes.push_back(
        {.name = name, .truth = std::move(boxes), .predictions = std::move(predicted->second)});
    predicted_boxes.erase(predicted);
  }
  if (!predicted_boxes.empty()) {
    throw FormatError(truth.string() + ": no truth of the predicted scene '" +
                      predicted_boxes.begin()->first + "'");
  }
  return scenes;
}

}  // namespace arbox::evaluation
