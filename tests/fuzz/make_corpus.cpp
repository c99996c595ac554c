// Writes the seed corpora of the fuzz targets: fuzz_make_corpus tests/fuzz/corpus
//
// Every seed is made here from a few numbers; none is cut from a dataset. Files named finding_* in
// a corpus are inputs that once broke a parser; this program leaves them alone.
#include <cstdint>
#include <filesystem>
#include <iostream>
#include <span>
#include <string>
#include <vector>

#include "arbox/base/error.h"
#include "arbox/io/file.h"
#include "arbox/io/npy.h"
#include "arbox/io/npz.h"

namespace {

namespace fs = std::filesystem;

void write(const fs::path& root, const std::string& target, const std::string& name,
           const std::string& content) {
  fs::create_directories(root / target);
  arbox::io::write_file(root / target / name, content);
}

std::string with_header(std::string dictionary, char version, const std::string& data) {
  std::string bytes = "\x93NUMPY";
  bytes += {version, '\0', static_cast<char>(dictionary.size()), '\0'};
  if (version > 1) bytes += {'\0', '\0'};
  return bytes + dictionary + data;
}

void make_npy(const fs::path& root) {
  const std::vector<float> floats{1.5F, -2.0F, 0.25F, 3.0F, 4.0F, 5.0F, 6.0F, 7.0F};
  const std::vector<std::int64_t> integers{1, -2, 3, 4};
  const auto points = arbox::io::encode_npy<float>(floats, {2, 4});
  const auto labels = arbox::io::encode_npy<std::int64_t>(integers, {4});
  write(root, "npy", "points.npy", points);
  write(root, "npy", "labels.npy", labels);
  write(root, "npy", "empty.npy", arbox::io::encode_npy<float>({}, {0, 4}));
  write(root, "npy", "scalar.npy", arbox::io::encode_npy<float>(std::span(floats).first(1), {}));
  write(root, "npy", "fortran_big_endian.npy",
        with_header("{'descr': '>f2', 'fortran_order': True, 'shape': (3, 2), }\n", 2,
                    std::string("\x3c\x00\x7c\x00\x7e\x00\x00\x01\x80\x00\xbc\x00", 12)));
  write(root, "npy", "bool_version_3.npy",
        with_header("{\"shape\": (3L,), 'descr': '|b1', 'fortran_order': False}", 3,
                    std::string("\1\0\1", 3)));
  write(root, "npz", "one.npz", arbox::io::encode_npz({{"points", points}}));
  write(root, "npz", "two.npz", arbox::io::encode_npz({{"pc", points}, {"labels", labels}}));
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::cerr << "usage: fuzz_make_corpus FOLDER\n";
    return 2;
  }
  try {
    make_npy(argv[1]);
  } catch (const arbox::Error& error) {
    std::cerr << "fuzz_make_corpus: " << error.what() << '\n';
    return 1;
  }
  return 0;
}
