#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "arbox/io/kitti_object.h"

namespace arbox::benchmarks {

/// Labels of a folder by class.
struct LabelFigures {
  std::map<std::string, std::vector<io::KittiObject>> objects;
  double frames = 0;
};

LabelFigures read_labels(const std::filesystem::path& folder);

/// Heading in the LiDAR frame, (-pi, pi].
double heading(const io::KittiObject& object);
double distance(const io::KittiObject& object);

/// A table: counts, distances, occlusion, truncation and headings by class.
void print_labels(const LabelFigures& real, const LabelFigures& simulated);

}  // namespace arbox::benchmarks
