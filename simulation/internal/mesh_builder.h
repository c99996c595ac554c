#pragma once

#include <Eigen/Geometry>
#include <span>
#include <vector>

#include "arbox/simulation/mesh.h"

namespace arbox::simulation {

using Point = Eigen::Vector3f;

/// Puts a mesh together from simple bodies. Metres, in the frame of the mesh.
class MeshBuilder {
 public:
  void triangle(const Point& a, const Point& b, const Point& c, Material material);
  /// Corners in order round the quad.
  void quad(const Point& a, const Point& b, const Point& c, const Point& d, Material material);
  /// An axis-aligned block.
  void block(const Point& low, const Point& high, Material material);
  /// A cone frustum with closed ends.
  void cylinder(const Point& from, const Point& to, float from_radius, float to_radius, int sides,
                Material material);
  void ellipsoid(const Point& center, const Point& radii, Material material, int rings = 5,
                 int sides = 8);
  /// A limb: a frustum with round ends.
  void limb(const Point& from, const Point& to, float from_radius, float to_radius,
            Material material);
  /// A flat fan that closes the polygon.
  void fan(std::span<const Point> polygon, Material material);

  TriangleMesh take() { return std::move(mesh_); }
  const TriangleMesh& mesh() const { return mesh_; }

 private:
  std::uint32_t add(const Point& point);
  TriangleMesh mesh_;
};

}  // namespace arbox::simulation
