#include "arbox/simulation/internal/vehicle_parts.h"

#include <algorithm>
#include <array>

namespace arbox::simulation {
namespace {

using Section = std::array<Point, 8>;

/// Half a section, from the middle of the floor to the middle of the roof.
Section section_of(const Station& s, float sign) {
  const float low = std::min(s.bottom + 0.14f, s.shoulder);
  const float middle = 0.45f * s.bottom + 0.55f * s.shoulder;
  const auto at = [&](float y, float z) { return Point(s.x, sign * y, z); };
  return {at(0, s.bottom),
          at(0.86f * s.half_shoulder, s.bottom),
          at(0.965f * s.half_shoulder, low),
          at(s.half_shoulder, middle),
          at(0.955f * s.half_shoulder, s.shoulder),
          at(s.half_top, s.top),
          at(0.72f * s.half_top, s.top + 0.030f),
          at(0, s.top + 0.045f)};
}

}  // namespace

void loft(MeshBuilder& body, std::span<const Station> stations) {
  for (const float sign : {-1.0f, 1.0f}) {
    for (std::size_t i = 0; i + 1 < stations.size(); ++i) {
      const Section a = section_of(stations[i], sign), b = section_of(stations[i + 1], sign);
      for (std::size_t strip = 0; strip + 1 < a.size(); ++strip) {
        const Material material = strip < 2    ? Material::kPlastic
                                  : strip < 4  ? Material::kPaintLight
                                  : strip == 4 ? stations[i].side
                                               : stations[i].roof;
        body.quad(a[strip], b[strip], b[strip + 1], a[strip + 1], material);
      }
    }
    body.fan(section_of(stations.front(), sign), Material::kPaintLight);
    body.fan(section_of(stations.back(), sign), Material::kPaintLight);
  }
}

void add_seat(MeshBuilder& body, float x, float y, float width, float cushion, float top) {
  body.block({x - 0.05f, y - width / 2, cushion - 0.14f}, {x + 0.45f, y + width / 2, cushion},
             Material::kCloth);
  body.block({x - 0.14f, y - width / 2, cushion}, {x, y + width / 2, top}, Material::kCloth);
  if (width < 0.8f) {
    body.block({x - 0.16f, y - 0.13f, top}, {x - 0.07f, y + 0.13f, top + 0.2f}, Material::kCloth);
  }
}

void add_wheel(MeshBuilder& body, float x, float outer, float inner, float radius) {
  const float rim = outer + (outer > inner ? -.004f : .004f);
  body.cylinder({x, inner, radius}, {x, rim, radius}, radius, radius, 14, Material::kRubber);
  body.cylinder({x, inner, radius}, {x, outer, radius}, .62f * radius, .60f * radius, 12,
                Material::kMetal);
}

}  // namespace arbox::simulation
