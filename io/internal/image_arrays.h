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

/// Masks (N, H, W), set where the number is above one half. Memory: one byte a number beside the
/// array for bytes and booleans in C order, five for others.
std::vector<std::vector<std::uint8_t>> masks_of(const RgbdImages& images, const NpyArray& masks,
                                                const std::string& place);

/// Makes the cloud of the depth and point_objects of the visible masks.
void fill_cloud(LabeledScene& scene);

/// The .npy bytes of pixels (H, W, 3) over `scale` as float32 (3, H, W).
template <class Number>
std::string plane_array(const std::vector<Number>& pixels, float scale, std::size_t height,
                        std::size_t width);

/// The .npy bytes (N, H, W) of masks of that size.
std::string mask_array(const std::vector<std::vector<std::uint8_t>>& masks, std::size_t height,
                       std::size_t width);

/// Throws InvalidArgument "WHERE: scene NAME: .." unless the scene has images of one size in the
/// frame `camera`, and either no masks or one of each kind an object.
void require_cob3d_writable(const LabeledScene& scene, const std::string& where);

}  // namespace arbox::io::internal
