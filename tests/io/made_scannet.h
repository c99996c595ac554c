#pragma once

#include <algorithm>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "arbox/io/point_cloud_file.h"
#include "arbox/io/scannet.h"
#include "support/program.h"

/// \file
/// Folders in the layout of ScanNet's raw release.

namespace arbox::testing {

/// Labels of a raw release: one vertex segment an instance, cut into pieces of `piece` vertices.
struct RawScan {
  std::string name = {};
  geometry::PointCloud cloud = {};
  /// Object of each vertex from 1, 0 for none, and the annotator's word of each object.
  std::vector<std::uint32_t> instances = {};
  std::map<std::uint32_t, std::string> labels = {};
  std::string alignment = {};
};

inline void write_raw_scan(const TemporaryDirectory& folder, const RawScan& scan,
                           std::size_t piece = 50) {
  const std::string base = "scans/" + scan.name + "/" + scan.name;
  folder.write(
      base + ".txt",
      "numDepthFrames = 5578\n" +
          (scan.alignment.empty() ? std::string() : "axisAlignment = " + scan.alignment + "\n") +
          "sceneType = Apartment\n");
  io::write_point_cloud(folder / (base + "_vh_clean_2.ply"), scan.cloud.view());
  std::map<std::uint32_t, std::vector<std::int64_t>> segments;
  std::map<std::uint32_t, std::size_t> seen;
  std::string indices;
  for (const std::uint32_t instance : scan.instances) {
    const auto segment =
        static_cast<std::int64_t>(1000 * instance + seen[instance]++ / piece % 1000);
    auto& list = segments[instance];
    if (list.empty() || list.back() != segment) list.push_back(segment);
    indices += (indices.empty() ? "" : ",") + std::to_string(segment);
  }
  folder.write(base + "_vh_clean_2.0.010000.segs.json",
               R"({"params":{"kThresh":"0.01","segMinVerts":"20"},"sceneId":")" + scan.name +
                   R"(","segIndices":[)" + indices + "]}");
  std::string groups;
  for (const auto& [instance, label] : scan.labels) {
    std::string list;
    for (const std::int64_t segment : segments[instance]) {
      list += (list.empty() ? "" : ",") + std::to_string(segment);
    }
    groups += (groups.empty() ? "" : ",") + std::string(R"({"id":)") +
              std::to_string(instance - 1) + R"(,"objectId":)" + std::to_string(instance - 1) +
              R"(,"segments":[)" + list + R"(],"label":")" + label + "\"}";
  }
  folder.write(base + ".aggregation.json",
               R"({"sceneId":"scannet.)" + scan.name + R"(","segGroups":[)" + groups + "]}");
}

/// A label map whose raw categories are "raw <id>" for NYU40 ids, and some of ScanNet's own words.
inline std::string made_label_map() {
  std::string text = "id\traw_category\tcategory\tcount\tnyu40id\teigen13id\n";
  for (int id = 1; id <= 40; ++id) {
    text += std::to_string(id) + "\traw " + std::to_string(id) + "\tx\t1\t" + std::to_string(id) +
            "\t\n";
  }
  return text + "50\toffice chair\tchair\t7\t5\t1\n51\tpaper cutter\tpaper cutter\t1\t\t\n";
}

}  // namespace arbox::testing
