#pragma once

#include <filesystem>
#include <string>

#include "arbox/io/labeled_scene.h"

/// \file
/// COB-3D: bins seen by a depth camera, with boxes of nine degrees of freedom
/// (docs/datasets/cob3d.md). Both versions come as scenes in the frame `camera` with `images`
/// (depth, colours, normals, masks), a cloud made of the depth and objects of class "object".
/// open_dataset() reads whole folders.

namespace arbox::io {

/// Reads FOLDER/data.npz and, where they are, FOLDER/annotation/{segm,bbox3d}.npz of version 1.
/// Pixels whose depth is not a finite number above 0 hold 0. Throws IoError for a missing data.npz,
/// FormatError for missing arrays, shapes that do not fit each other, sizes that are not above zero
/// and orientations that are no unit quaternions within 1e-3.
LabeledScene read_cob3d_scene(const std::filesystem::path& folder);

/// Writes such a folder: rgb, depth, normals as float32, masks as bytes, boxes as float64. The
/// scene must be in the frame `camera` and have images; throws InvalidArgument otherwise and for
/// masks that are not one an object (a scene may have none), IoError.
void write_cob3d_scene(const std::filesystem::path& folder, const LabeledScene& scene);

/// Reads scenes/ID.npz of version 2, whose dictionaries are pickles (io/pickle.h: nothing is run).
/// The half axes of a box are the columns of its pose times extents / scales. Throws as
/// read_cob3d_scene.
LabeledScene read_cob3d_v2_scene(const std::filesystem::path& file);

/// Writes such a file. Poses have unit axes, scales are 1, extents are half sizes. What a scene
/// does not tell is written as plainly as the layout allows: the voxel grid of an object is one
/// filled voxel, near and far plane are the least and largest depth, 2-D boxes are the hulls of the
/// amodal masks; there are no meshes. Throws as write_cob3d_scene.
void write_cob3d_v2_scene(const std::filesystem::path& file, const LabeledScene& scene);

}  // namespace arbox::io
