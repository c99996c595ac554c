#include "arbox/io/image_size.h"

#include <cstdint>
#include <string>

#include "arbox/base/error.h"
#include "arbox/io/file.h"

namespace arbox::io {
namespace {

constexpr std::string_view kSignature("\x89PNG\r\n\x1a\n\0\0\0\rIHDR", 16);
constexpr std::size_t kHeaderBytes = 33;
constexpr std::uint32_t kMostPixels = 1u << 20;

std::uint32_t big_endian(std::string_view bytes) {
  std::uint32_t value = 0;
  for (const char byte : bytes) value = value << 8 | static_cast<unsigned char>(byte);
  return value;
}

std::uint32_t crc32(std::string_view bytes) {
  std::uint32_t remainder = ~0u;
  for (const char byte : bytes) {
    remainder ^= static_cast<unsigned char>(byte);
    for (int bit = 0; bit < 8; ++bit) {
      remainder = remainder >> 1 ^ (remainder & 1 ? 0xedb88320u : 0u);
    }
  }
  return ~remainder;
}

}  // namespace

ImageSize parse_png_size(std::string_view header, std::string_view source) {
  const auto refuse = [&](const std::string& expected, const std::string& came) {
    throw FormatError(std::string(source) + ": expected " + expected + ", got " + came);
  };
  if (header.size() < kHeaderBytes) {
    refuse("a PNG image", "only " + std::to_string(header.size()) + " bytes");
  }
  if (!header.starts_with(kSignature)) refuse("a PNG image", "another beginning");
  const std::uint32_t width = big_endian(header.substr(16, 4));
  const std::uint32_t height = big_endian(header.substr(20, 4));
  if (width == 0 || height == 0 || width > kMostPixels || height > kMostPixels) {
    refuse("1 to 1048576 pixels a side", std::to_string(width) + " x " + std::to_string(height));
  }
  if (crc32(header.substr(12, 17)) != big_endian(header.substr(29, 4))) {
    refuse("the check sum of the PNG header", "another; the file is damaged");
  }
  return {static_cast<int>(width), static_cast<int>(height)};
}

ImageSize read_png_size(const std::filesystem::path& path) {
  return parse_png_size(read_file(path, kHeaderBytes), path.string());
}

}  // namespace arbox::io
