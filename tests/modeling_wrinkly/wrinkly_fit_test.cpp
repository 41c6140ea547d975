#include "modeling/wrinkly/wrinkly_fit.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "modeling/bezier/shell_solids.h"
#include "modeling/wrinkly/bear.h"
#include "modeling/wrinkly/surface_nets.h"
#include "wrinkly_meshes.h"

namespace annulus {
namespace {

using Eigen::Vector3d;

TEST(WrinklyFit, RecoversControlHeightsOfASyntheticTexture) {
  for (const char* kind : {"regular:12x10", "torus:9x8", "directions:3x4", "ring:9x5", "spiral:8x50"}) {
    const ControlMeshParts parts = RoughNet(kind, 3);
    const WrinklySurface surface = WrinklySurface::Make(ControlMesh::Make(parts).value(), {}).value();
    for (const int iterations : {0, 2, 3}) {
      // Heights of 0.3 % noise, at four places per patch and digit.
      std::vector<WrinklyTarget> targets;
      std::uint64_t n = 0;
      for (PointIndex patch = 0; patch < static_cast<PointIndex>(parts.points.size()); ++patch) {
        for (int k = 0; k < 200; ++k) {
          WrinklyTarget target{patch, ScatteredNumber(7, ++n), ScatteredNumber(8, n), 0.0};
          const auto parts_u = surface.level(iterations).u().parts();
          const MeshPlace place{patch, static_cast<std::uint32_t>(target.u * parts_u),
                                static_cast<std::uint32_t>(target.v * parts_u), std::fmod(target.u * parts_u, 1.0),
                                std::fmod(target.v * parts_u, 1.0)};
          target.value = surface.Height(place, iterations, iterations) + 0.006 * (ScatteredNumber(9, n) - 0.5);
          targets.push_back(target);
        }
      }
      const WrinklyFit fit = FitWrinklyValues(surface, iterations, targets, {}).value();
      EXPECT_EQ(fit.points_without, 0U);
      const double error = (fit.values - parts.values.col(0)).norm() / parts.values.col(0).norm();
      EXPECT_LT(error, 0.01) << kind << ' ' << iterations;
      EXPECT_NEAR(fit.rms, 0.006 / std::sqrt(12.0), 2e-4) << kind;
      EXPECT_GT(fit.rms_before, 0.1) << kind;
    }
  }
}

TEST(WrinklyFit, RefusesTargetsThatAreNowhere) {
  const WrinklySurface surface =
      WrinklySurface::Make(ControlMesh::Make(MakeNet("bordered:3x3").value()).value(), {}).value();
  const auto fit = [&](const WrinklyTarget& target, int iterations = 1) {
    return FitWrinklyValues(surface, iterations, std::span(&target, 1), {}).has_value();
  };
  EXPECT_TRUE(fit({6, 0.5, 0.5, 1.0}));
  EXPECT_FALSE(fit({0, 0.5, 0.5, 1.0}));  // a temporary point
  EXPECT_FALSE(fit({99, 0.5, 0.5, 1.0}));
  EXPECT_FALSE(fit({6, 1.5, 0.5, 1.0}));
  EXPECT_FALSE(fit({6, 0.5, 0.5, std::nan("")}));
  EXPECT_FALSE(fit({6, 0.5, 0.5, 1.0}, 25));
  EXPECT_FALSE(FitWrinklyValues(surface, 1, {}, {}).has_value());
}

TEST(SurfaceNets, TouchABoxInTheMiddleOfEveryPatch) {
  const PatchShell box = BoxShell("box", Eigen::Isometry3d::Identity(), {30, 20, 10});
  const auto parts = NetOfShell(box, 4);
  ASSERT_TRUE(parts) << parts.error().Text();
  EXPECT_EQ(parts->points.size(), 6U * 16U);
  const ControlMesh mesh = ControlMesh::Make(*parts, FamilyRule::kCut).value();
  EXPECT_GT(mesh.cut_count(), 0U);
  const BaseSurface surface = BaseSurface::Make(mesh, CornerJoin::kPaper).value();
  for (PointIndex patch = 0; patch < 96; ++patch) {
    const Vector3d middle = surface.At(patch, 0.5, 0.5).point;
    // On the box: one coordinate at its half size, the others within.
    const Vector3d share = middle.cwiseAbs().cwiseQuotient(Vector3d(30, 20, 10));
    EXPECT_NEAR(share.maxCoeff(), 1.0, 1e-6) << patch;
  }
}

TEST(Bear, IsOneClosedTwoFamilyMeshWithSixfoldCells) {
  const Bear bear = MakeBear(1);
  const auto mesh = ControlMesh::Make(bear.mesh);
  ASSERT_TRUE(mesh) << mesh.error().Text();
  EXPECT_EQ(mesh->cut_count(), 0U);
  int sixfold = 0;
  int caps = 0;
  int index = 0;  // Σ (4 − corners), two caps' worth (8) in all for a sphere
  for (const MeshCell& cell : mesh->cells()) {
    EXPECT_FALSE(cell.open);
    if (cell.closed) {
      ++caps;
      index += 4;
      continue;
    }
    if (cell.corners.size() == 6) ++sixfold;
    index += 4 - static_cast<int>(cell.corners.size());
  }
  EXPECT_EQ(sixfold, 2 * 7);
  EXPECT_EQ(caps, 2 + 7);
  EXPECT_EQ(index, 8);
  ASSERT_TRUE(BaseSurface::Make(*mesh, CornerJoin::kRounded));
}

}  // namespace
}  // namespace annulus
