#pragma once

#include <filesystem>
#include <string_view>

namespace arbox::io {

/// Pixels of an image.
struct ImageSize {
  int width = 0;
  int height = 0;
  friend bool operator==(const ImageSize&, const ImageSize&) = default;
};

/// The size that a PNG file's header tells; reads 33 bytes and decodes nothing. Throws FormatError
/// if `header` does not begin with a PNG signature and an intact IHDR chunk of 1 to 2^20 pixels a
/// side.
ImageSize parse_png_size(std::string_view header, std::string_view source);

/// The same from a file; throws IoError for a missing file or a directory.
ImageSize read_png_size(const std::filesystem::path& path);

}  // namespace arbox::io
