#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "arbox/io/labeled_scene.h"
#include "arbox/io/npy.h"

/// \file
/// Arrays of pictures as COB-3D's files hold them: (H, W), (3, H, W), (N, H, W).

namespace arbox::io::internal {

/// Throws FormatError "PLACE: expected WHAT, got an array of A x B" unless the shape is that.
void require_shape(const NpyArray& array, const std::vector<std::size_t>& shape,
                   const std::string& place, const std::string& what);

/// Sets size and depth; what is not a finite number above 0 becomes 0.
void set_depth(RgbdImages& images, const NpyArray& depth, const std::string& place);

/// Colours (3, H, W) in 0..1 or 0..255, told apart by a number above 1.
void set_rgb(RgbdImages& images, const NpyArray& rgb, const std::string& place);

/// Normals (3, H, W).
void set_normals(RgbdImages& images, const NpyArray& normals, const std::string& place);

void set_intrinsic(RgbdImages& images, const NpyArray& matrix, const std::string& place);

/// Masks (N, H, W), set where the number is above one half.
std::vector<std::vector<std::uint8_t>> masks_of(const RgbdImages& images, const NpyArray& masks,
                                                const std::string& place);

/// Makes the cloud of the depth and point_objects of the visible masks.
void fill_cloud(LabeledScene& scene);

}  // namespace arbox::io::internal
