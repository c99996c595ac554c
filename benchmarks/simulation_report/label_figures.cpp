#include "label_figures.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>

#include "arbox/geometry/rotation.h"
#include "arbox/io/kitti.h"
#include "arbox/io/kitti_label.h"
#include "scan_figures.h"

namespace arbox::benchmarks {

LabelFigures read_labels(const std::filesystem::path& folder) {
  LabelFigures figures;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    figures.frames += 1;
    for (const io::KittiObject& label : io::read_kitti_labels(entry.path())) {
      figures.objects[label.type].push_back(label);
    }
  }
  return figures;
}

double heading(const io::KittiObject& object) {
  return geometry::wrap_angle(-object.rotation_y - 0.5 * std::numbers::pi);
}

double distance(const io::KittiObject& object) { return std::hypot(object.x, object.z); }

void print_labels(const LabelFigures& real, const LabelFigures& simulated) {
  std::printf(
      "\n| class | | a frame | distance 5/50/95 %% | occlusion 0/1/2/3 | truncated | "
      "same / opposite heading | left |\n|---|---|---|---|---|---|---|---|\n");
  for (const char* type : {"Car", "Van", "Truck", "Pedestrian", "Person_sitting", "Cyclist", "Tram",
                           "Misc", "DontCare"}) {
    for (const auto& [name, figures] : {std::pair{"real", &real}, {"simulated", &simulated}}) {
      const auto found = figures->objects.find(type);
      if (found == figures->objects.end()) continue;
      const auto& objects = found->second;
      const double n = static_cast<double>(objects.size());
      std::printf("| %s | %s | %.3f |", type, name, n / figures->frames);
      if (!io::has_box(objects[0])) {
        std::printf(" | | | | |\n");
        continue;
      }
      std::vector<double> distance;
      double level[4] = {}, truncated = 0, same = 0, opposite = 0, left = 0;
      for (const io::KittiObject& object : objects) {
        distance.push_back(benchmarks::distance(object));
        ++level[std::clamp(object.occlusion, 0, 3)];
        truncated += object.truncation > 0;
        same += std::abs(heading(object)) < 0.35;
        opposite += std::abs(heading(object)) > std::numbers::pi - 0.35;
        left += object.x < 0;
      }
      std::printf(" %.1f / %.1f / %.1f | %.2f / %.2f / %.2f / %.2f | %.2f | %.2f / %.2f | %.2f |\n",
                  quantile(distance, .05), quantile(distance, .5), quantile(distance, .95),
                  level[0] / n, level[1] / n, level[2] / n, level[3] / n, truncated / n, same / n,
                  opposite / n, left / n);
    }
  }
}

}  // namespace arbox::benchmarks
