#include <algorithm>
#include <functional>
#include <map>
#include <set>

#include "arbox/io/arbox_dataset.h"
#include "arbox/io/file.h"
#include "arbox/io/internal/dataset_layouts.h"
#include "arbox/io/label_file.h"
#include "arbox/io/point_cloud_file.h"

namespace arbox::io {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kValidationShare = 5;

std::set<std::string> cloud_names(const fs::path& folder) {
  std::set<std::string> names;
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (format_of_extension(entry.path())) names.insert(entry.path().stem().string());
  }
  return names;
}

/// Classes of all label files, the most frequent first.
std::vector<std::string> count_classes(const fs::path& folder, std::size_t& files) {
  std::map<std::string, std::size_t> counts;
  for (const char* ending : {".json", ".txt"}) {
    for (const std::string& name : internal::names_in(folder, ending)) {
      ++files;
      for (const auto& object : read_label_file(folder / (name + ending)).objects) {
        ++counts[object.label];
      }
    }
  }
  std::vector<std::string> classes;
  for (const auto& [name, count] : counts) classes.push_back(name);
  std::stable_sort(classes.begin(), classes.end(),
                   [&](const auto& a, const auto& b) { return counts[a] > counts[b]; });
  return classes;
}

class Initializer {
 public:
  Initializer(const fs::path& root, InitReport& report) : root_(root), report_(report) {}

  void folder(const std::string& name) {
    if (fs::is_directory(root_ / name)) return;
    internal::make_folder(root_ / name);
    report_.made.push_back(name + "/");
  }

  void file(const std::string& name, const std::string& content) {
    if (fs::exists(root_ / name)) return;
    write_file(root_ / name, content);
    report_.made.push_back(name);
  }

 private:
  const fs::path& root_;
  InitReport& report_;
};

void note_what_is_missing(const fs::path& root, InitReport& report) {
  const std::size_t loose = list_point_clouds(root).size();
  if (loose > 0) {
    report.notes.push_back("move the " + std::to_string(loose) + " clouds of " + root.string() +
                           " into " + (root / "points").string());
  }
  if (report.scans == 0) {
    report.notes.push_back("put clouds (.pcd .ply .bin .npy .npz .csv) into " +
                           (root / "points").string());
  }
  if (report.labels == 0) {
    report.notes.push_back("put labels of the same names (.json or .txt) into " +
                           (root / "labels").string());
  }
}

}  // namespace

InitReport init_dataset(const fs::path& root, const DatasetDescription& description) {
  InitReport report;
  Initializer make(root, report);
  internal::make_folder(root);
  make.folder("points");
  make.folder("labels");
  const std::set<std::string> scans = cloud_names(root / "points");
  report.scans = scans.size();
  DatasetDescription filled = description;
  report.classes = count_classes(root / "labels", report.labels);
  if (filled.classes.empty()) filled.classes = report.classes;
  make.file("dataset.json", format_dataset_description(filled));
  if (!scans.empty() && !fs::exists(root / "splits")) {
    make.folder("splits");
    std::string train, val;
    std::size_t number = 0;
    for (const std::string& name : scans) {
      (number++ % kValidationShare == kValidationShare - 1 ? val : train) += name + "\n";
    }
    make.file("splits/train.txt", train);
    make.file("splits/val.txt", val);
  }
  note_what_is_missing(root, report);
  return report;
}

}  // namespace arbox::io
