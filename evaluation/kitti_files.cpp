#include "arbox/evaluation/kitti_files.h"

#include <algorithm>
#include <exception>
#include <set>
#include <sstream>

#include "arbox/base/error.h"
#include "arbox/base/parallel.h"
#include "arbox/io/file.h"
#include "arbox/io/kitti_label.h"

namespace arbox::evaluation {
namespace {

namespace fs = std::filesystem;

constexpr std::int64_t kFilesAtOnce = 32;

void require_folder(const fs::path& folder, const char* content) {
  if (!fs::is_directory(folder)) {
    throw IoError(folder.string() + ": expected a folder of " + content + ", got " +
                  (fs::exists(folder) ? "a file" : "nothing"));
  }
}

std::vector<std::string> names_of_split(const fs::path& split) {
  std::vector<std::string> names;
  std::set<std::string> seen;
  std::istringstream words(io::read_file(split));
  for (std::string name; words >> name;) {
    if (!seen.insert(name).second) {
      throw FormatError(split.string() + ": frame " + name + " is listed twice");
    }
    names.push_back(name);
  }
  if (names.empty()) throw FormatError(split.string() + ": expected frame names, got none");
  return names;
}

std::vector<std::string> names_in_folder(const fs::path& predictions) {
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(predictions)) {
    if (entry.path().extension() == ".txt") names.push_back(entry.path().stem().string());
  }
  if (names.empty()) throw IoError(predictions.string() + ": holds no result file (*.txt)");
  std::sort(names.begin(), names.end());
  return names;
}

KittiFrame read_frame(const fs::path& label, const fs::path& prediction) {
  if (!fs::exists(prediction)) {
    throw IoError(prediction.string() +
                  ": no such result file; write an empty one where nothing was found");
  }
  if (!fs::exists(label)) {
    throw IoError(label.string() + ": no such label file, but " + prediction.string() +
                  " has results");
  }
  return {.labels = io::read_kitti_labels(label),
          .predictions = io::read_kitti_results(prediction)};
}

}  // namespace

std::vector<std::string> kitti_frame_names(const fs::path& predictions,
                                           const std::optional<fs::path>& split) {
  require_folder(predictions, "result files");
  return split ? names_of_split(*split) : names_in_folder(predictions);
}

KittiFrames read_kitti_frames(const fs::path& labels, const fs::path& predictions,
                              const std::optional<fs::path>& split, int threads,
                              const std::function<void()>& read) {
  require_folder(labels, "label files");
  KittiFrames result;
  result.names = kitti_frame_names(predictions, split);
  result.frames.resize(result.names.size());
  std::vector<std::exception_ptr> errors(result.names.size());
  parallel_for(static_cast<std::int64_t>(result.names.size()), kFilesAtOnce, threads,
               [&](std::int64_t begin, std::int64_t end) {
                 for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end);
                      ++i) {
                   const std::string file = result.names[i] + ".txt";
                   try {
                     result.frames[i] = read_frame(labels / file, predictions / file);
                   } catch (...) {
                     errors[i] = std::current_exception();
                   }
                   if (read) read();
                 }
               });
  for (const std::exception_ptr& error : errors) {
    if (error) std::rethrow_exception(error);
  }
  return result;
}

}  // namespace arbox::evaluation
