#include "arbox/simulation/mesh.h"

namespace arbox::simulation {

const MaterialProperties& properties(Material material) {
  static const std::array<MaterialProperties, kMaterialCount> table = {{
      {.reflectivity = 0.33, .spread = 0.03},                               // asphalt
      {.reflectivity = 0.38, .spread = 0.05},                               // concrete
      {.reflectivity = 0.38, .spread = 0.06},                               // grass
      {.reflectivity = 0.37, .spread = 0.05},                               // gravel
      {.reflectivity = 0.38, .spread = 0.06},                               // brick
      {.reflectivity = 0.44, .spread = 0.08},                               // plaster
      {.reflectivity = 0.40, .spread = 0.08},                               // wood
      {.reflectivity = 0.33, .spread = 0.07},                               // bark
      {.reflectivity = 0.37, .spread = 0.10},                               // foliage
      {.reflectivity = 0.33, .spread = 0.15, .loss = 0.05},                 // metal
      {.reflectivity = 0.70, .spread = 2.20, .loss = 0.20, .gloss = 0.87},  // light paint
      {.reflectivity = 0.12, .spread = 0.90, .loss = 0.24, .gloss = 0.90},  // dark paint
      {.reflectivity = 0.03, .spread = 0.02, .transmission = 0.70, .loss = 0.26, .gloss = 0.8},
      {.reflectivity = 0.06, .spread = 0.03, .loss = 0.05},                // rubber
      {.reflectivity = 0.20, .spread = 0.12, .loss = 0.03, .gloss = 0.5},  // plastic
      {.reflectivity = 0.36, .spread = 0.12},                              // cloth
      {.reflectivity = 0.42, .spread = 0.05},                              // skin
      {.reflectivity = 0.95, .spread = 0.05},                              // retroreflector
  }};
  return table[static_cast<std::size_t>(material)];
}

bool takes_brightness(Material material) {
  switch (material) {
    case Material::kGlass:
    case Material::kRubber:
    case Material::kRetroreflector:
    case Material::kSkin:
      return false;
    default:
      return true;
  }
}

void TriangleMesh::append(const TriangleMesh& other, const Eigen::Isometry3f& pose) {
  const auto first = static_cast<std::uint32_t>(vertices.size());
  for (const Eigen::Vector3f& vertex : other.vertices) vertices.push_back(pose * vertex);
  for (const auto& triangle : other.triangles) {
    triangles.push_back({triangle[0] + first, triangle[1] + first, triangle[2] + first});
  }
  materials.insert(materials.end(), other.materials.begin(), other.materials.end());
}

Eigen::AlignedBox3f TriangleMesh::bounds() const {
  Eigen::AlignedBox3f box;
  for (const Eigen::Vector3f& vertex : vertices) box.extend(vertex);
  return vertices.empty() ? Eigen::AlignedBox3f(Eigen::Vector3f::Zero().eval()) : box;
}

}  // namespace arbox::simulation
