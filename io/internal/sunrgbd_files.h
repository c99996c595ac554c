#pragma once

#include <algorithm>
#include <array>
#include <cctype>
#include <filesystem>
#include <string>
#include <string_view>

#include "arbox/geometry/point_cloud_view.h"

namespace arbox::io::internal {

inline constexpr std::array<std::string_view, 3> kSunRgbdImages = {".jpg", ".jpeg", ".png"};

inline bool is_image_number(std::string_view name) {
  return !name.empty() && std::all_of(name.begin(), name.end(), [](unsigned char letter) {
    return std::isdigit(letter) != 0;
  });
}

/// 5051 is scene 005051; other names stay.
inline std::string sunrgbd_scene_name(std::string_view listed) {
  constexpr std::size_t kDigits = 6;
  std::string name(listed);
  return is_image_number(listed) && listed.size() < kDigits
             ? std::string(kDigits - listed.size(), '0') + name
             : name;
}

/// The points of depth/NAME.mat. Throws IoError, FormatError.
geometry::PointCloud read_sunrgbd_depth(const std::filesystem::path& path);

/// Writes such a file: x y z r g b, colours 0 where the cloud has none. Throws IoError.
void write_sunrgbd_depth(const std::filesystem::path& path, const geometry::PointCloud& cloud);

}  // namespace arbox::io::internal
