#include "arbox/simulation/models.h"

#include <gtest/gtest.h>

#include <cmath>

namespace arbox::simulation {
namespace {

TEST(Models, EveryShapeTouchesItsBoxOnAllSidesAndOnlyMirrorsLeaveIt) {
  for (int kind = 0; kind < kModelKindCount; ++kind) {
    const auto type = static_cast<ModelKind>(kind);
    for (int variant = 0; variant < variant_count(type); ++variant) {
      SCOPED_TRACE(testing::Message() << "kind " << kind << " variant " << variant);
      const Model& shape = model(type, variant);
      ASSERT_GT(shape.mesh->triangles.size(), 4u);
      ASSERT_EQ(shape.mesh->materials.size(), shape.mesh->triangles.size());
      const Eigen::AlignedBox3f bounds = shape.mesh->bounds();
      const double overhang = type <= ModelKind::kArticulatedTruck ? kMirrorOverhang : 0.0;
      for (const int axis : {0, 1, 2}) {
        const double slack = axis == 1 ? overhang : 0.0;
        EXPECT_LE(bounds.max()[axis], 0.5 * shape.size[axis] + slack + 1e-3);
        EXPECT_GE(bounds.max()[axis], 0.5 * shape.size[axis] - 1e-3);
        EXPECT_GE(bounds.min()[axis], -0.5 * shape.size[axis] - slack - 1e-3);
        EXPECT_LE(bounds.min()[axis], -0.5 * shape.size[axis] + 1e-3);
      }
    }
  }
}

// In real scans of cars seen from an end, a quarter of the returns of the bumper's corners lies 0.2
// m and more behind the label's face (docs/simulation.md).
TEST(Models, BumpersOfCarsRunBackTowardsTheirCorners) {
  for (const auto kind : {ModelKind::kSmallCar, ModelKind::kHatchback, ModelKind::kSedan,
                          ModelKind::kEstate, ModelKind::kSuv, ModelKind::kMinivan}) {
    for (int variant = 0; variant < variant_count(kind); ++variant) {
      SCOPED_TRACE(testing::Message() << static_cast<int>(kind) << " variant " << variant);
      const Model& car = model(kind, variant);
      for (const Eigen::Vector3f& vertex : car.mesh->vertices) {
        const double depth = 0.5 * car.size.x() - std::abs(vertex.x());
        const double side = std::abs(vertex.y()) / (0.5 * car.size.y());
        if (side > 0.3) {
          EXPECT_GT(depth, 0.02) << vertex.transpose();
        }
        if (side > 0.7) {
          EXPECT_GT(depth, 0.09) << vertex.transpose();
        }
        if (side > 0.9) {
          EXPECT_GT(depth, 0.15) << vertex.transpose();
        }
      }
    }
  }
}

TEST(Models, RoofsOfCarsRiseBehindTheWindscreen) {
  for (const auto kind : {ModelKind::kSmallCar, ModelKind::kHatchback, ModelKind::kSedan,
                          ModelKind::kEstate, ModelKind::kSuv, ModelKind::kMinivan}) {
    for (int variant = 0; variant < variant_count(kind); ++variant) {
      SCOPED_TRACE(testing::Message() << static_cast<int>(kind) << " variant " << variant);
      const Model& car = model(kind, variant);
      Eigen::Vector3f foremost(-10, 0, 0), highest(0, 0, -10);
      for (const Eigen::Vector3f& vertex : car.mesh->vertices) {
        if (std::abs(vertex.y()) > 1e-4f || vertex.z() < 0.30f * car.size.z()) continue;
        if (vertex.x() > foremost.x()) foremost = vertex;
        if (vertex.z() > highest.z()) highest = vertex;
      }
      EXPECT_GT(highest.z() - foremost.z(), 0.08f);
      EXPECT_LT(highest.z() - foremost.z(), 0.25f);
      EXPECT_GT(foremost.x() - highest.x(), 0.3f);
      EXPECT_GT(0.5f * car.size.x() - foremost.x(), 0.33f * car.size.x());
    }
  }
}

TEST(Models, IndicesAndCoordinatesAreValid) {
  for (int kind = 0; kind < kModelKindCount; ++kind) {
    const TriangleMesh& mesh = *model(static_cast<ModelKind>(kind), 0).mesh;
    for (const auto& triangle : mesh.triangles) {
      for (const std::uint32_t corner : triangle) ASSERT_LT(corner, mesh.vertices.size());
    }
    for (const Eigen::Vector3f& vertex : mesh.vertices) ASSERT_TRUE(vertex.allFinite());
  }
}

TEST(Models, VariantsDifferAndNumbersWrapRound) {
  const Model& first = model(ModelKind::kSedan, 0);
  EXPECT_NE(first.size, model(ModelKind::kSedan, 1).size);
  EXPECT_EQ(first.mesh, model(ModelKind::kSedan, variant_count(ModelKind::kSedan)).mesh);
  EXPECT_EQ(model(ModelKind::kSedan, -1).mesh,
            model(ModelKind::kSedan, variant_count(ModelKind::kSedan) - 1).mesh);
}

}  // namespace
}  // namespace arbox::simulation
