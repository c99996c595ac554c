#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "arbox/drawing/color.h"

namespace arbox::drawing {

/// A picture in memory: rows from top to bottom, 8-bit RGB. A default image has no pixels.
struct Image {
  int width = 0;
  int height = 0;
  /// width * height * 3 bytes.
  std::vector<std::uint8_t> pixels;

  Image() = default;
  /// An image of one colour. Throws InvalidArgument unless both sizes are within 1..16384.
  Image(int width, int height, Color background);

  bool empty() const { return pixels.empty(); }
  /// The colour of a pixel, 0 <= x < width, 0 <= y < height.
  Color at(int x, int y) const {
    const std::size_t i = 3 * (static_cast<std::size_t>(y) * width + x);
    return {pixels[i], pixels[i + 1], pixels[i + 2]};
  }
};

/// Reads a PNG or JPEG file as 8-bit RGB. Throws IoError for a file that cannot be
/// read and FormatError for one that is no image or is larger than 16384 pixels on a side.
Image read_image(const std::filesystem::path& path);

/// Throws InvalidArgument, with the path and the extensions, unless the extension is one that
/// write_image knows.
void require_image_extension(const std::filesystem::path& path);

/// The image as a PNG file's bytes, the same bytes every time.
std::string encode_png(const Image& image);

/// Writes PNG or JPEG, chosen by the extension .png, .jpg or .jpeg (any case). Throws
/// InvalidArgument for an empty image or another extension, IoError if the file cannot be written.
void write_image(const Image& image, const std::filesystem::path& path);

}  // namespace arbox::drawing
