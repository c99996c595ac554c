#pragma once

#include <Eigen/Core>
#include <memory>

#include "arbox/simulation/mesh.h"

namespace arbox::simulation {

/// What can stand in a street. The comment says which axis the shape follows.
enum class ModelKind {
  kSmallCar,  ///< Vehicles: x forward.
  kHatchback,
  kSedan,
  kEstate,
  kSuv,
  kMinivan,
  kPanelVan,
  kMinibus,
  kBoxTruck,
  kArticulatedTruck,
  kTram,
  kTrailer,
  kPedestrian,  ///< Persons: x is where they look.
  kCyclist,
  kPersonSitting,
  kBroadTree,
  kConifer,
  kTrunk,
  kBush,
  kHedge,  ///< 2 m along x.
  kPole,
  kStreetLamp,
  kTrafficSign,  ///< Faces +x.
  kTrafficLight,
  kBollard,
  kLitterBin,
  kWheeledBin,
  kSwitchCabinet,
  kCrate,
  kBench,
  kParkedBicycle,
  kWall,         ///< 2 m along x.
  kPicketFence,  ///< 2 m along x.
  kMeshFence,
  kGuardRail,  ///< 4 m along x.
  kHouse,      ///< Front at +y looks to +y, x along the street.
  kTownHouse,
  kHall,
};
inline constexpr int kModelKindCount = static_cast<int>(ModelKind::kHall) + 1;

/// A shape that many instances share, with its nominal box: centred at the origin of the mesh,
/// sizes along x, y, z. Everything lies within the box but the mirrors of vehicles, which stick out
/// sideways by up to kMirrorOverhang, as they do from the boxes that people draw. The body touches
/// each of the six faces within 1 mm.
struct Model {
  std::shared_ptr<const TriangleMesh> mesh;
  Eigen::Vector3d size = Eigen::Vector3d::Zero();
};

/// Metres, before an instance is scaled.
inline constexpr double kMirrorOverhang = 0.09;

/// How many shapes there are of a kind, at least 1.
int variant_count(ModelKind kind);

/// The shape number `variant` modulo variant_count(kind); equal numbers give equal triangles. Built
/// once in a process and kept. May be called from several threads.
const Model& model(ModelKind kind, int variant);

}  // namespace arbox::simulation
