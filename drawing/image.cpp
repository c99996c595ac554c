#include "arbox/drawing/image.h"

#include <algorithm>
#include <cctype>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "arbox/base/error.h"
#include "arbox/io/file.h"

namespace arbox::drawing {
namespace {

constexpr int kMaxSide = 16384;

std::string lower_extension(const std::filesystem::path& path) {
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension;
}

std::string encode(const Image& image, const std::string& extension) {
  if (image.empty()) throw InvalidArgument("write_image: the image has no pixels");
  const cv::Mat rgb(image.height, image.width, CV_8UC3,
                    const_cast<std::uint8_t*>(image.pixels.data()));
  cv::Mat bgr;
  cv::cvtColor(rgb, bgr, cv::COLOR_RGB2BGR);
  std::vector<std::uint8_t> bytes;
  cv::imencode(extension, bgr, bytes, {cv::IMWRITE_JPEG_QUALITY, 95});
  return {bytes.begin(), bytes.end()};
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
  // libpng would print its own message for a file that was cut.
  if (bytes.starts_with("\x89PNG") && bytes.find("IEND") == std::string::npos) {
    throw FormatError(path.string() + ": the PNG file ends after " + std::to_string(bytes.size()) +
                      " bytes, before its last chunk");
  }
  cv::Mat decoded;
  try {
    const cv::Mat buffer(1, static_cast<int>(bytes.size()), CV_8UC1,
                         const_cast<char*>(bytes.data()));
    decoded = cv::imdecode(buffer, cv::IMREAD_COLOR);
  } catch (const cv::Exception&) {
    decoded.release();
  }
  if (decoded.empty()) {
    throw FormatError(path.string() + ": expected a PNG, JPEG, BMP, TIFF or PPM image");
  }
  if (decoded.cols > kMaxSide || decoded.rows > kMaxSide) {
    throw FormatError(path.string() + ": expected at most 16384 pixels a side, got " +
                      std::to_string(decoded.cols) + " x " + std::to_string(decoded.rows));
  }
  Image image(decoded.cols, decoded.rows, {});
  cv::Mat rgb(image.height, image.width, CV_8UC3, image.pixels.data());
  cv::cvtColor(decoded, rgb, cv::COLOR_BGR2RGB);
  return image;
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
