#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <vector>

namespace arbox::simulation {

/// What a surface is made of, as far as a laser sees it.
enum class Material : std::uint8_t {
  kAsphalt,
  kConcrete,
  kGrass,
  kGravel,
  kBrick,
  kPlaster,
  kWood,
  kBark,
  kFoliage,
  kMetal,
  kPaintLight,
  kPaintDark,
  kGlass,
  kRubber,
  kPlastic,
  kCloth,
  kSkin,
  kRetroreflector,
};
inline constexpr int kMaterialCount = static_cast<int>(Material::kRetroreflector) + 1;

/// How a material answers a pulse of 905 nm.
struct MaterialProperties {
  /// Diffuse reflectivity as the sensor reports it at normal incidence, in units of intensity
  /// (0..1): its mean, and its spread, of which 0.35 is the standard deviation from pulse to pulse.
  /// Paint glitters: flakes, edges and trim.
  double reflectivity = 0.3, spread = 0.08;
  /// Probability that the pulse goes on through the surface.
  double transmission = 0.0;
  /// Probability that the pulse is lost at normal incidence beyond what range and angle explain
  /// (specular surfaces send it elsewhere).
  double loss = 0.0;
  /// Share of the reflectivity that lies in a narrow lobe about the normal (glossy paint).
  double gloss = 0.0;
};
const MaterialProperties& properties(Material material);

/// True if an instance's brightness changes this material: paint, cloth, walls and plants, but not
/// glass, tyres, reflectors and skin.
bool takes_brightness(Material material);

/// Triangles in a frame of their own, metres. Counter-clockwise seen from outside.
struct TriangleMesh {
  std::vector<Eigen::Vector3f> vertices;
  std::vector<std::array<std::uint32_t, 3>> triangles;
  /// One for each triangle.
  std::vector<Material> materials;

  /// Appends another mesh, moved by `pose`.
  void append(const TriangleMesh& other, const Eigen::Isometry3f& pose);
  /// Bounds of the vertices; both zero for an empty mesh.
  Eigen::AlignedBox3f bounds() const;
};

}  // namespace arbox::simulation
