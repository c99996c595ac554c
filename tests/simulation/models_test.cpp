#include "arbox/simulation/models.h"

#include <gtest/gtest.h>

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
