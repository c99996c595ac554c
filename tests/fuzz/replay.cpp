// Runs a fuzz target once over every file of the folders given: what an ordinary build replays.
#include <cstdint>
#include <exception>
#include <filesystem>
#include <iostream>

#include "arbox/io/file.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

int main(int argc, char** argv) {
  int count = 0;
  try {
    for (int i = 1; i < argc; ++i) {
      for (const auto& entry : std::filesystem::directory_iterator(argv[i])) {
        const std::string content = arbox::io::read_file(entry.path());
        LLVMFuzzerTestOneInput(reinterpret_cast<const std::uint8_t*>(content.data()),
                               content.size());
        ++count;
      }
    }
  } catch (const std::exception& error) {
    std::cerr << "after " << count << " inputs: " << error.what() << '\n';
    return 1;
  }
  std::cout << count << " inputs replayed\n";
  return count > 0 ? 0 : 1;
}
