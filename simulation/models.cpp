#include "arbox/simulation/models.h"

#include <algorithm>
#include <array>
#include <mutex>

#include "arbox/simulation/internal/model_builders.h"

namespace arbox::simulation {
namespace {

constexpr int kMostVariants = 24;
constexpr std::uint64_t kShapeSeed = 20221023;

void build(ModelKind kind, Dice& dice, MeshBuilder& body, MeshBuilder& overhang) {
  switch (kind) {
    case ModelKind::kBoxTruck:
    case ModelKind::kArticulatedTruck:
      return build_truck(dice, kind == ModelKind::kArticulatedTruck, body, overhang);
    case ModelKind::kTram:
      return build_tram(dice, body);
    case ModelKind::kTrailer:
      return build_trailer(dice, body);
    case ModelKind::kPedestrian:
      return build_pedestrian(dice, body);
    case ModelKind::kPersonSitting:
      return build_person_sitting(dice, body);
    case ModelKind::kCyclist:
      return build_cyclist(dice, body);
    case ModelKind::kParkedBicycle:
      return build_bicycle(dice, body);
    default:
      break;
  }
  if (kind < ModelKind::kBoxTruck) return build_vehicle(kind, dice, body, overhang);
  if (kind >= ModelKind::kHouse) return build_building(kind, dice, body);
  if (kind >= ModelKind::kBroadTree && kind <= ModelKind::kHedge) {
    return build_plant(kind, dice, body);
  }
  build_furniture(kind, dice, body);
}

/// Moves the middle of the body's bounds to the origin.
Model finished(const TriangleMesh& body, const TriangleMesh& overhang) {
  const Eigen::AlignedBox3f bounds = body.bounds();
  const Eigen::Isometry3f centred(Eigen::Translation3f(-bounds.center()));
  const auto mesh = std::make_shared<TriangleMesh>();
  mesh->append(body, centred);
  mesh->append(overhang, centred);
  return {.mesh = mesh, .size = bounds.sizes().cast<double>()};
}

struct Shelf {
  std::array<std::once_flag, kMostVariants> built;
  std::array<Model, kMostVariants> models;
};

}  // namespace

int variant_count(ModelKind kind) {
  if (kind == ModelKind::kPedestrian) return kMostVariants;
  if (kind <= ModelKind::kMinibus || kind == ModelKind::kCyclist) return 8;
  if (kind == ModelKind::kHouse || kind == ModelKind::kTownHouse) return 10;
  return 6;
}

const Model& model(ModelKind kind, int variant) {
  static std::array<Shelf, kModelKindCount> shelves;
  Shelf& shelf = shelves[static_cast<std::size_t>(kind)];
  const int count = variant_count(kind);
  const auto number = static_cast<std::size_t>(((variant % count) + count) % count);
  std::call_once(shelf.built[number], [&] {
    Dice dice(kShapeSeed, number, static_cast<std::uint32_t>(kind));
    MeshBuilder body, overhang;
    build(kind, dice, body, overhang);
    shelf.models[number] = finished(body.mesh(), overhang.mesh());
  });
  return shelf.models[number];
}

}  // namespace arbox::simulation
