#include "arbox/io/internal/image_arrays.h"

#include <algorithm>
#include <cmath>

#include "arbox/base/error.h"

namespace arbox::io::internal {
namespace {

constexpr std::size_t kMostPixels = std::size_t{1} << 30;

std::string shape_text(const std::vector<std::size_t>& shape) {
  std::string text;
  for (const std::size_t size : shape) text += (text.empty() ? "" : " x ") + std::to_string(size);
  return text.empty() ? "one number" : text;
}

std::vector<std::size_t> planes(const RgbdImages& images, std::size_t count) {
  return {count, static_cast<std::size_t>(images.height), static_cast<std::size_t>(images.width)};
}

/// (3, H, W) to (H, W, 3).
template <class T, class Convert>
void interleave(const std::vector<float>& planes_of_three, std::vector<T>& pixels,
                const Convert& convert) {
  const std::size_t count = planes_of_three.size() / 3;
  pixels.resize(3 * count);
  for (std::size_t c = 0; c < 3; ++c) {
    for (std::size_t i = 0; i < count; ++i) {
      pixels[3 * i + c] = convert(planes_of_three[c * count + i]);
    }
  }
}

}  // namespace

void require_shape(const NpyArray& array, const std::vector<std::size_t>& shape,
                   const std::string& place, const std::string& what) {
  if (array.shape() == shape) return;
  throw FormatError(place + ": expected " + what + " (" + shape_text(shape) +
                    "), got an array of " + shape_text(array.shape()));
}

void set_depth(RgbdImages& images, const NpyArray& depth, const std::string& place) {
  const auto& shape = depth.shape();
  if (shape.size() != 2 || shape[0] == 0 || shape[1] == 0 || shape[0] > kMostPixels / shape[1]) {
    throw FormatError(place + ": expected a depth image (height x width), got an array of " +
                      shape_text(shape));
  }
  images.height = static_cast<int>(shape[0]);
  images.width = static_cast<int>(shape[1]);
  images.depth = depth.values<float>();
  for (float& number : images.depth) {
    if (!(std::isfinite(number) && number > 0.0F)) number = 0.0F;
  }
}

void set_rgb(RgbdImages& images, const NpyArray& rgb, const std::string& place) {
  require_shape(rgb, planes(images, 3), place, "colours");
  const std::vector<float> values = rgb.values<float>();
  const bool bytes =
      std::any_of(values.begin(), values.end(), [](float value) { return value > 1.0F; });
  const float scale = bytes ? 1.0F : 255.0F;
  interleave(values, images.rgb, [&](float value) {
    // NaN becomes 0.
    return static_cast<std::uint8_t>(value > 0.0F ? std::min(value * scale + 0.5F, 255.0F) : 0.0F);
  });
}

void set_normals(RgbdImages& images, const NpyArray& normals, const std::string& place) {
  require_shape(normals, planes(images, 3), place, "normals");
  interleave(normals.values<float>(), images.normals, [](float value) { return value; });
}

void set_intrinsic(RgbdImages& images, const NpyArray& matrix, const std::string& place) {
  require_shape(matrix, {3, 3}, place, "a pinhole matrix");
  const std::vector<double> numbers = matrix.values<double>();
  images.intrinsic = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(numbers.data());
  if (!images.intrinsic.allFinite() || images.intrinsic.determinant() == 0.0) {
    throw FormatError(place + ": expected an invertible pinhole matrix");
  }
}

std::vector<std::vector<std::uint8_t>> masks_of(const RgbdImages& images, const NpyArray& masks,
                                                const std::string& place) {
  const std::size_t count = masks.shape().empty() ? 0 : masks.shape()[0];
  require_shape(masks, planes(images, count), place, "masks");
  const std::size_t pixels = images.depth.size();
  std::vector<std::vector<std::uint8_t>> result(count, std::vector<std::uint8_t>(pixels));
  const NumberType type = masks.header().type;
  const bool bytes = type == NumberType::kBool || type == NumberType::kUint8;
  if (bytes && !masks.header().fortran_order) {
    // As they lie, with no copy between.
    const std::string_view data = masks.data();
    for (std::size_t i = 0; i < data.size(); ++i) result[i / pixels][i % pixels] = data[i] != 0;
    return result;
  }
  const std::vector<float> values = masks.values<float>();
  for (std::size_t i = 0; i < values.size(); ++i) {
    result[i / pixels][i % pixels] = values[i] > 0.5F ? 1 : 0;
  }
  return result;
}

void fill_cloud(LabeledScene& scene) {
  scene.cloud = to_cloud(*scene.images);
  const auto& masks = scene.images->visible_masks;
  if (masks.empty()) return;
  for (const std::int32_t pixel : pixels_of_cloud(*scene.images)) {
    std::int32_t object = -1;
    for (std::size_t n = 0; n < masks.size(); ++n) {
      if (masks[n][static_cast<std::size_t>(pixel)] != 0) object = static_cast<std::int32_t>(n);
    }
    scene.point_objects.push_back(object);
  }
}

template <class Number>
std::string plane_array(const std::vector<Number>& pixels, float scale, std::size_t height,
                        std::size_t width) {
  const std::size_t count = pixels.size() / 3;
  std::vector<float> result(pixels.size());
  for (std::size_t i = 0; i < count; ++i) {
    for (std::size_t c = 0; c < 3; ++c) {
      result[c * count + i] = static_cast<float>(pixels[3 * i + c]) / scale;
    }
  }
  return encode_npy<float>(result, {3, height, width});
}

template std::string plane_array(const std::vector<float>&, float, std::size_t, std::size_t);
template std::string plane_array(const std::vector<std::uint8_t>&, float, std::size_t, std::size_t);

std::string mask_array(const std::vector<std::vector<std::uint8_t>>& masks, std::size_t height,
                       std::size_t width) {
  std::vector<std::uint8_t> all;
  for (const auto& mask : masks) all.insert(all.end(), mask.begin(), mask.end());
  return encode_npy<std::uint8_t>(all, {masks.size(), height, width});
}

void require_cob3d_writable(const LabeledScene& scene, const std::string& where) {
  const std::string place = where + ": scene " + scene.name;
  if (scene.frame != SceneFrame::kCamera || !scene.images) {
    throw InvalidArgument(place +
                          ": expected images in the frame camera; COB-3D's layout holds "
                          "depth images, no clouds");
  }
  const RgbdImages& images = *scene.images;
  const auto pixels = static_cast<std::size_t>(images.width) * images.height;
  const auto fits = [&](std::size_t size, std::size_t channels) {
    return size == 0 || size == channels * pixels;
  };
  if (images.depth.size() != pixels || !fits(images.rgb.size(), 3) ||
      !fits(images.normals.size(), 3)) {
    throw InvalidArgument(place + ": expected images of one size");
  }
  if (images.visible_masks.size() != images.amodal_masks.size()) {
    throw InvalidArgument(place + ": expected one mask of each kind an object");
  }
  for (const auto* masks : {&images.visible_masks, &images.amodal_masks}) {
    const bool sized = std::all_of(masks->begin(), masks->end(),
                                   [&](const auto& mask) { return mask.size() == pixels; });
    if ((!masks->empty() && masks->size() != scene.objects.size()) || !sized) {
      throw InvalidArgument(place + ": expected one mask of the image's size an object");
    }
  }
}

}  // namespace arbox::io::internal
