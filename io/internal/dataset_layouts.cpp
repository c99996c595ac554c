#include "arbox/io/internal/dataset_layouts.h"

#include <algorithm>

#include "arbox/base/error.h"
#include "arbox/geometry/enclosing_box.h"
#include "arbox/geometry/rotation.h"
#include "arbox/io/file.h"
#include "arbox/io/internal/text.h"

namespace arbox::io::internal {
namespace {

namespace fs = std::filesystem;

constexpr double kEqual = 1e-9;

/// True if the box had to be enclosed by another.
bool fit_box(LabeledObject& object, BoxForm form) {
  geometry::Box& box = object.box;
  if (form == BoxForm::kAny) return false;
  if (form == BoxForm::kAxisAligned) {
    object.heading = Heading::kUnknown;
    if (box.rotation.angularDistance(geometry::Quaternion::Identity()) < 1e-9) return false;
    const Eigen::AlignedBox3d hull = geometry::axis_aligned_hull(box);
    const double volume = geometry::volume(box);
    box = {.center = hull.center(), .size = hull.sizes()};
    return geometry::volume(box) > (1.0 + kEqual) * volume;
  }
  if (geometry::is_yaw_only(box, 1e-6)) return false;
  const auto corners = geometry::corners(box);
  const geometry::Quaternion upright =
      geometry::make_yaw_box({}, Eigen::Vector3d::Ones(), geometry::yaw(box)).rotation;
  const double volume = geometry::volume(box);
  box = *geometry::enclosing_box(corners, {&upright, 1});
  return geometry::volume(box) > (1.0 + kEqual) * volume;
}

void require_consistent(const LabeledScene& scene) {
  const auto objects = static_cast<std::int32_t>(scene.objects.size());
  const bool sized =
      scene.point_objects.empty() || scene.point_objects.size() == scene.cloud.size();
  if (!sized ||
      std::any_of(scene.point_objects.begin(), scene.point_objects.end(),
                  [&](std::int32_t object) { return object < -1 || object >= objects; })) {
    throw InvalidArgument("scene " + quoted_text(scene.name) +
                          ": expected for each point -1 or one of its " + std::to_string(objects) +
                          " objects in point_objects");
  }
  if (!scene.images) return;
  for (const auto* masks : {&scene.images->visible_masks, &scene.images->amodal_masks}) {
    if (!masks->empty() && masks->size() != scene.objects.size()) {
      throw InvalidArgument("scene " + quoted_text(scene.name) +
                            ": expected one mask an object, got " + std::to_string(masks->size()) +
                            " for " + std::to_string(objects));
    }
  }
}

/// Puts `kept` in place of the scene's objects; object i is new_index[i] of them, -1 if none.
void keep_objects(LabeledScene& scene, const std::vector<std::int32_t>& new_index,
                  std::vector<LabeledObject> kept) {
  for (std::int32_t& object : scene.point_objects) {
    if (object >= 0) object = new_index[object];
  }
  if (scene.images) {
    for (auto* masks : {&scene.images->visible_masks, &scene.images->amodal_masks}) {
      std::vector<std::vector<std::uint8_t>> left;
      for (std::size_t i = 0; i < masks->size(); ++i) {
        if (new_index[i] >= 0) left.push_back(std::move((*masks)[i]));
      }
      *masks = std::move(left);
    }
  }
  scene.objects = std::move(kept);
}

}  // namespace

std::vector<std::string> ListedDataset::splits() const {
  std::vector<std::string> names;
  for (const auto& [name, scenes] : lists_) names.push_back(name);
  return names;
}

std::vector<std::string> ListedDataset::names(std::string_view split) const {
  for (const auto& [name, scenes] : lists_) {
    if (name == split) return scenes;
  }
  throw InvalidArgument(root_.string() + ": expected one of the splits " + joined(splits(), ", ") +
                        ", got " + quoted_text(split));
}

void ListedDataset::add_split(std::string name, std::vector<std::string> scenes) {
  lists_.emplace_back(std::move(name), std::move(scenes));
}

void ListedDataset::require_scene(std::string_view split, std::string_view name) const {
  const auto list = std::find_if(lists_.begin(), lists_.end(),
                                 [&](const auto& entry) { return entry.first == split; });
  if (list == lists_.end()) names(split);  // Refuses it.
  if (std::find(list->second.begin(), list->second.end(), name) != list->second.end()) return;
  throw InvalidArgument(root_.string() + ": split " + std::string(split) + " holds no scene " +
                        quoted_text(name));
}

std::vector<std::string> names_in(const Folder& folder, std::string_view ending) {
  std::vector<std::string> names;
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end;
       entry.increment(error)) {
    const std::string file = entry->path().filename().string();
    if (file.size() <= ending.size() || !file.ends_with(ending) || file.front() == '.') continue;
    names.push_back(file.substr(0, file.size() - ending.size()));
  }
  std::sort(names.begin(), names.end());
  return names;
}

fs::path first_file(const Folder& folder, std::string_view name,
                    std::span<const std::string_view> endings) {
  std::error_code ignored;
  for (const std::string_view ending : endings) {
    fs::path path = folder / (std::string(name) + std::string(ending));
    if (fs::is_regular_file(path, ignored)) return path;
  }
  return {};
}

void AccountingWriter::enlist(const std::string& split, const std::string& name) {
  if (name.empty() || name.front() == '.' ||
      name.find_first_of("/\\ \t\r\n") != std::string::npos) {
    throw InvalidArgument("scene " + quoted_text(name) +
                          ": expected a name that can be a file's (no separators or blanks, no "
                          "dot at its front)");
  }
  const std::scoped_lock lock(mutex_);
  if (!seen_.insert(name).second) {
    throw InvalidArgument("scene " + quoted_text(name) + ": given a second time");
  }
  auto list = std::find_if(lists_.begin(), lists_.end(),
                           [&](const auto& entry) { return entry.first == split; });
  if (list == lists_.end()) list = lists_.insert(lists_.end(), {split, {}});
  list->second.push_back(name);
}

LabeledScene AccountingWriter::fitted(const LabeledScene& scene) {
  require_consistent(scene);
  LabeledScene result = converted(scene, form_.frame);
  WriteReport report{.scenes = 1};
  const auto known = [&](const LabeledObject& object) {
    return form_.classes.empty() || std::find(form_.classes.begin(), form_.classes.end(),
                                              object.label) != form_.classes.end();
  };
  std::vector<std::int32_t> new_index(result.objects.size(), -1);
  std::vector<LabeledObject> kept;
  for (std::size_t i = 0; i < result.objects.size(); ++i) {
    LabeledObject& object = result.objects[i];
    geometry::require_valid(object.box,
                            "scene " + quoted_text(scene.name) + ", object " + std::to_string(i));
    if (!known(object)) {
      ++report.left_out[object.label];
      continue;
    }
    report.enclosed += fit_box(object, form_.boxes) ? 1 : 0;
    new_index[i] = static_cast<std::int32_t>(kept.size());
    kept.push_back(std::move(object));
  }
  report.objects = kept.size();
  keep_objects(result, new_index, std::move(kept));
  const std::scoped_lock lock(mutex_);
  ++report_.scenes;
  report_.objects += report.objects;
  report_.enclosed += report.enclosed;
  for (const auto& [label, count] : report.left_out) report_.left_out[label] += count;
  return result;
}

void AccountingWriter::add(const std::string& split, const LabeledScene& scene) {
  enlist(split, scene.name);
  write(split, fitted(scene));
}

WriteReport AccountingWriter::finish() {
  write_rest();
  return report_;
}

void AccountingWriter::note(const std::string& what, std::size_t count) {
  if (count == 0) return;
  const std::scoped_lock lock(mutex_);
  report_.notes[what] += count;
}

std::size_t AccountingWriter::class_number(const LabeledObject& object) const {
  const auto found = std::find(form_.classes.begin(), form_.classes.end(), object.label);
  return static_cast<std::size_t>(found - form_.classes.begin());
}

std::vector<std::pair<std::string, std::vector<std::string>>> AccountingWriter::lists() const {
  const std::scoped_lock lock(mutex_);
  auto sorted = lists_;
  for (auto& [split, names] : sorted) std::sort(names.begin(), names.end());
  return sorted;
}

void AccountingWriter::write_lists(const Folder& folder, const std::string& prefix,
                                   const std::string& suffix) const {
  for (const auto& [split, names] : lists()) {
    std::string text;
    for (const std::string& name : names) text += name + '\n';
    write_file(folder / (prefix + split + suffix), text);
  }
}

void make_folder(const Folder& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) throw IoError(folder.string() + ": cannot be made: " + error.message());
}

}  // namespace arbox::io::internal
