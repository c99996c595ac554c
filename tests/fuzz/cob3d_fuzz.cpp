#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "arbox/io/cob3d.h"
#include "arbox/io/file.h"
#include "arbox/io/npz.h"
#include "fuzz_input.h"

namespace {

namespace fs = std::filesystem;

/// A scene of two by two pixels and one object, of which one file is what the fuzzer makes.
class Scene {
 public:
  Scene() : folder_(fs::temp_directory_path() / ("arbox_fuzz_" + std::to_string(::getpid()))) {
    using arbox::io::encode_npy;
    const std::vector<float> depth{1, 2, 0, 4};
    const std::vector<double> intrinsic{5, 0, 1, 0, 5, 1, 0, 0, 1}, row{1, 1, 1}, turn{1, 0, 0, 0};
    const std::vector<std::uint8_t> mask{0, 1, 1, 0};
    parts_ = {
        {"data.npz", arbox::io::encode_npz({{"depth", encode_npy<float>(depth, {2, 2})},
                                            {"intrinsic", encode_npy<double>(intrinsic, {3, 3})}})},
        {"annotation/segm.npz",
         arbox::io::encode_npz({{"masks", encode_npy<std::uint8_t>(mask, {1, 2, 2})},
                                {"masks_amodal", encode_npy<std::uint8_t>(mask, {1, 2, 2})}})},
        {"annotation/bbox3d.npz",
         arbox::io::encode_npz({{"dimensions", encode_npy<double>(row, {1, 3})},
                                {"centers", encode_npy<double>(row, {1, 3})},
                                {"orientations", encode_npy<double>(turn, {1, 4})}})}};
    fs::create_directories(folder_ / "annotation");
    for (const auto& [name, content] : parts_) arbox::io::write_file(folder_ / name, content);
  }
  ~Scene() { fs::remove_all(folder_); }

  void read_with(std::size_t part, std::string_view content) {
    // Files are whole again when the next one is not.
    if (part != changed_) {
      arbox::io::write_file(folder_ / parts_[changed_].first, parts_[changed_].second);
      changed_ = part;
    }
    std::ofstream(folder_ / parts_[part].first, std::ios::binary) << content;
    arbox::io::read_cob3d_scene(folder_);
  }

 private:
  fs::path folder_;
  std::vector<std::pair<std::string, std::string>> parts_;
  std::size_t changed_ = 0;
};

}  // namespace

// The first byte chooses which file of the scene the others are.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  static Scene scene;
  return arbox::fuzz::run(data + 1, size - 1,
                          [&](std::string_view bytes) { scene.read_with(data[0] % 3, bytes); });
}
