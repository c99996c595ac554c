#include <algorithm>

#include "arbox/base/error.h"
#include "arbox/io/cob3d.h"
#include "arbox/io/file.h"
#include "arbox/io/internal/dataset_layouts.h"
#include "arbox/io/json.h"

// Folders of COB-3D behind DatasetReader and DatasetWriter.

namespace arbox::io::internal {
namespace {

namespace fs = std::filesystem;

std::vector<std::string> folders_in(const Folder& folder) {
  std::vector<std::string> names;
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end;
       entry.increment(error)) {
    if (entry->is_directory(error)) names.push_back(entry->path().filename().string());
  }
  std::sort(names.begin(), names.end());
  return names;
}

std::vector<std::string> scenes_in(const Folder& split) {
  std::vector<std::string> names = folders_in(split);
  std::erase_if(names, [&](const std::string& name) {
    std::error_code ignored;
    return !fs::is_regular_file(split / name / "data.npz", ignored);
  });
  return names;
}

class Cob3dReader : public ListedDataset {
 public:
  explicit Cob3dReader(const Folder& folder) : ListedDataset(folder) {
    std::vector<std::string> all;
    for (const std::string& split : folders_in(folder)) {
      std::vector<std::string> names = scenes_in(folder / split);
      if (names.empty()) continue;
      for (const std::string& name : names) all.push_back(split + "/" + name);
      add_split(split, std::move(names));
    }
    add_split(std::string(kAllScenes), std::move(all));
  }

  std::string_view layout() const override { return "cob3d"; }
  SceneFrame frame() const override { return SceneFrame::kCamera; }
  std::vector<std::string> classes() const override { return {"object"}; }

  LabeledScene load(std::string_view split, std::string_view name) const override {
    const Folder folder = split == kAllScenes ? root() : root() / split;
    return read_cob3d_scene(folder / name);
  }
};

class Cob3dV2Reader : public ListedDataset {
 public:
  explicit Cob3dV2Reader(const Folder& folder) : ListedDataset(folder) {
    const fs::path path = folder / "dset.json";
    const auto values = parse_json_values(read_file(path), path.string());
    if (values.size() != 1) {
      throw FormatError(path.string() + ": expected one object of splits");
    }
    const JsonCursor splits(values[0], path.string() + ": ");
    for (const std::string& split : splits.keys()) {
      std::vector<std::string> names;
      for (const JsonCursor& name : splits.at(split.c_str()).elements()) {
        names.push_back(name.text());
        if (names.back().find_first_of("/\\") != std::string::npos) name.refuse("a scene's id");
      }
      if (split != kAllScenes) add_split(split, std::move(names));
    }
    add_split(std::string(kAllScenes), names_in(folder / "scenes", ".npz"));
  }

  std::string_view layout() const override { return "cob3d-v2"; }
  SceneFrame frame() const override { return SceneFrame::kCamera; }
  std::vector<std::string> classes() const override { return {"object"}; }

  LabeledScene load(std::string_view, std::string_view name) const override {
    return read_cob3d_v2_scene(root() / "scenes" / (std::string(name) + ".npz"));
  }
};

class Cob3dWriter : public AccountingWriter {
 public:
  explicit Cob3dWriter(const Folder& folder)
      : AccountingWriter(folder, {.frame = SceneFrame::kCamera}) {}

 private:
  void write(const std::string& split, const LabeledScene& scene) override {
    write_cob3d_scene(root() / split / scene.name, scene);
  }
  void write_rest() override {}
};

class Cob3dV2Writer : public AccountingWriter {
 public:
  explicit Cob3dV2Writer(const Folder& folder)
      : AccountingWriter(folder, {.frame = SceneFrame::kCamera}) {
    make_folder(root() / "scenes");
  }

 private:
  void write(const std::string&, const LabeledScene& scene) override {
    write_cob3d_v2_scene(root() / "scenes" / (scene.name + ".npz"), scene);
  }
  void write_rest() override {
    Json splits = Json::object();
    for (const auto& [split, names] : lists()) splits[split] = names;
    write_file(root() / "dset.json", dump_json(splits, 1) + "\n");
  }
};

}  // namespace

bool fits_cob3d(const Folder& root) {
  const auto splits = folders_in(root);
  return std::any_of(splits.begin(), splits.end(),
                     [&](const std::string& split) { return !scenes_in(root / split).empty(); });
}

bool fits_cob3d_v2(const Folder& root) {
  return fs::exists(root / "dset.json") && fs::is_directory(root / "scenes");
}

Reader open_cob3d(const Folder& root, const DatasetOptions&) {
  return std::make_unique<Cob3dReader>(root);
}

Reader open_cob3d_v2(const Folder& root, const DatasetOptions&) {
  return std::make_unique<Cob3dV2Reader>(root);
}

Writer create_cob3d(const NewDataset& dataset) {
  return std::make_unique<Cob3dWriter>(dataset.root);
}

Writer create_cob3d_v2(const NewDataset& dataset) {
  return std::make_unique<Cob3dV2Writer>(dataset.root);
}

}  // namespace arbox::io::internal
