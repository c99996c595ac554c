#include "arbox/drawing/image.h"

#include <png.h>
#include <turbojpeg.h>

#include <algorithm>
#include <cctype>
#include <memory>

#include "arbox/base/error.h"
#include "arbox/io/file.h"

namespace arbox::drawing {
namespace {

constexpr int kMaxSide = 16384;
constexpr int kJpegQuality = 95;

std::string lower_extension(const std::filesystem::path& path) {
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension;
}

std::string encode_as_png(const Image& image) {
  png_image header{};
  header.version = PNG_IMAGE_VERSION;
  header.width = static_cast<png_uint_32>(image.width);
  header.height = static_cast<png_uint_32>(image.height);
  header.format = PNG_FORMAT_RGB;
  png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(header);
  std::string bytes(size, '\0');
  const bool written = png_image_write_to_memory(&header, bytes.data(), &size, 0,
                                                 image.pixels.data(), 0, nullptr) != 0;
  if (!written) throw IoError(std::string("write_image: PNG: ") + header.message);
  bytes.resize(size);
  return bytes;
}

std::string encode_as_jpeg(const Image& image) {
  const std::unique_ptr<void, int (*)(tjhandle)> codec(tjInitCompress(), tjDestroy);
  unsigned char* data = nullptr;
  unsigned long size = 0;  // NOLINT: the type of the library's interface
  const int failed = tjCompress2(codec.get(), image.pixels.data(), image.width, 0, image.height,
                                 TJPF_RGB, &data, &size, TJSAMP_444, kJpegQuality, 0);
  const std::unique_ptr<unsigned char, void (*)(unsigned char*)> owner(data, tjFree);
  if (failed != 0) throw IoError(std::string("write_image: JPEG: ") + tjGetErrorStr2(codec.get()));
  return {data, data + size};
}

std::string encode(const Image& image, const std::string& extension) {
  if (image.empty()) throw InvalidArgument("write_image: the image has no pixels");
  return extension == ".png" ? encode_as_png(image) : encode_as_jpeg(image);
}

void require_side(const std::string& name, std::uint32_t width, std::uint32_t height) {
  if (width >= 1 && height >= 1 && width <= kMaxSide && height <= kMaxSide) return;
  throw FormatError(name + ": expected 1 to 16384 pixels a side, got " + std::to_string(width) +
                    " x " + std::to_string(height));
}

Image decode_png(const std::string& name, const std::string& bytes) {
  png_image header{};
  header.version = PNG_IMAGE_VERSION;
  const std::unique_ptr<png_image, void (*)(png_imagep)> guard(&header, png_image_free);
  if (png_image_begin_read_from_memory(&header, bytes.data(), bytes.size()) == 0) {
    throw FormatError(name + ": broken PNG: " + header.message);
  }
  require_side(name, header.width, header.height);
  header.format = PNG_FORMAT_RGB;
  Image image(static_cast<int>(header.width), static_cast<int>(header.height), {});
  const png_color black{};
  if (png_image_finish_read(&header, &black, image.pixels.data(), 0, nullptr) == 0) {
    throw FormatError(name + ": broken PNG: " + header.message);
  }
  return image;
}

Image decode_jpeg(const std::string& name, const std::string& bytes) {
  const std::unique_ptr<void, int (*)(tjhandle)> codec(tjInitDecompress(), tjDestroy);
  const auto* data = reinterpret_cast<const unsigned char*>(bytes.data());
  int width = 0, height = 0, subsampling = 0, colors = 0;
  const auto refuse = [&] {
    throw FormatError(name + ": broken JPEG: " + tjGetErrorStr2(codec.get()));
  };
  if (tjDecompressHeader3(codec.get(), data, bytes.size(), &width, &height, &subsampling,
                          &colors) != 0) {
    refuse();
  }
  require_side(name, static_cast<std::uint32_t>(width), static_cast<std::uint32_t>(height));
  Image image(width, height, {});
  if (tjDecompress2(codec.get(), data, bytes.size(), image.pixels.data(), width, 0, height,
                    TJPF_RGB, TJFLAG_ACCURATEDCT) != 0) {
    refuse();
  }
  return image;
}

}  // namespace

Image::Image(int image_width, int image_height, Color background)
    : width(image_width), height(image_height) {
  if (width < 1 || height < 1 || width > kMaxSide || height > kMaxSide) {
    throw InvalidArgument("Image: size must be within 1..16384 pixels a side, got " +
                          std::to_string(width) + " x " + std::to_string(height));
  }
  pixels.resize(static_cast<std::size_t>(width) * height * 3);
  for (std::size_t i = 0; i < pixels.size(); i += 3) {
    pixels[i] = background.r;
    pixels[i + 1] = background.g;
    pixels[i + 2] = background.b;
  }
}

Image read_image(const std::filesystem::path& path) {
  const std::string bytes = io::read_file(path);
  if (bytes.empty()) throw FormatError(path.string() + ": expected an image, the file is empty");
  if (bytes.starts_with("\x89PNG")) return decode_png(path.string(), bytes);
  if (bytes.starts_with("\xff\xd8")) return decode_jpeg(path.string(), bytes);
  throw FormatError(path.string() + ": expected a PNG or JPEG image");
}

void require_image_extension(const std::filesystem::path& path) {
  const std::string extension = lower_extension(path);
  if (extension == ".png" || extension == ".jpg" || extension == ".jpeg") return;
  throw InvalidArgument(path.string() + ": expected the extension .png, .jpg or .jpeg, got '" +
                        extension + "'");
}

std::string encode_png(const Image& image) { return encode(image, ".png"); }

void write_image(const Image& image, const std::filesystem::path& path) {
  require_image_extension(path);
  io::write_file(path, encode(image, lower_extension(path)));
}

}  // namespace arbox::drawing
