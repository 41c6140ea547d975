#include "modeling/wrinkly/base_surface.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "modeling/wrinkly/quad_mesh.h"
#include "wrinkly_meshes.h"

namespace annulus {
namespace {

using Eigen::Vector3d;

/// The net raised to a saddle-shaped or bumpy place in space, so that nothing is flat.
ControlMeshParts Raised(const std::string& kind, double mm) {
  ControlMeshParts parts = MakeNet(kind).value();
  for (ControlPoint& point : parts.points) {
    const Vector3d& p = point.position;
    point.position.z() = mm * (std::sin(0.11 * p.x() + 0.3) + std::cos(0.13 * p.y()) + 0.004 * p.x() * p.y());
  }
  return parts;
}

TEST(BaseSurface, IsTheBiquadraticBSplineOnARegularMesh) {
  const ControlMeshParts parts = Raised("regular:5x5", 4.0);
  const ControlMesh mesh = ControlMesh::Make(parts).value();
  const BaseSurface surface = BaseSurface::Make(mesh, CornerJoin::kPaper).value();
  // Uniform quadratic B-spline about its middle control point, by its closed form.
  const auto basis = [](double t) {
    return std::array<double, 3>{0.5 * (1.0 - t) * (1.0 - t), 0.5 + t - t * t, 0.5 * t * t};
  };
  for (const double u : {0.0, 0.3, 1.0}) {
    for (const double v : {0.0, 0.6, 1.0}) {
      Vector3d expected = Vector3d::Zero();
      for (std::size_t i = 0; i < 3; ++i) {
        for (std::size_t j = 0; j < 3; ++j) {
          expected += basis(u)[i] * basis(v)[j] * parts.points[j * 5 + i].position;
        }
      }
      EXPECT_LT((surface.At(6, u, v).point - expected).norm(), 1e-12);
    }
  }
}

TEST(BaseSurface, HasNoGapsAndIsSmoothWhereItIsRegular) {
  for (const std::string& kind : MeshKinds()) {
    if (kind == "torus:3x4" || kind == "torus:1x1" || kind == "tube:5x3") continue;  // flat nets with a seam
    const ControlMesh mesh = ControlMesh::Make(Raised(kind, 3.0)).value();
    const BaseJoins joins = MeasureBaseJoins(mesh, BaseSurface::Make(mesh, CornerJoin::kPaper).value());
    EXPECT_LT(joins.largest_gap_mm, 1e-11) << kind;
    EXPECT_LT(joins.regular_largest, 1e-9) << kind;
  }
}

TEST(BaseSurface, LooksOutward) {
  for (const std::string& kind : MeshKinds()) {
    if (kind == "torus:3x4" || kind == "torus:1x1" || kind == "tube:5x3") continue;
    const ControlMesh mesh = NetMesh(kind);
    const BaseSurface surface = BaseSurface::Make(mesh, CornerJoin::kPaper).value();
    for (std::size_t k = 0; k < mesh.size(); ++k) {
      const auto patch = static_cast<PointIndex>(k);
      if (!mesh.HasPatch(patch)) continue;
      for (const double t : {0.0, 0.2, 0.7, 1.0}) {
        EXPECT_GT(surface.NormalAt(patch, surface.At(patch, t, 1.0 - t)).z(), 0.9) << kind << ' ' << k;
      }
    }
  }
}

TEST(BaseSurface, RoundedCornersHaveATangentPlane) {
  for (const int n : {3, 4, 5, 6}) {
    const ControlMesh mesh = ControlMesh::Make(Raised("directions:" + std::to_string(n) + "x3", 6.0)).value();
    const BaseJoins paper = MeasureBaseJoins(mesh, BaseSurface::Make(mesh, CornerJoin::kPaper).value());
    const BaseJoins rounded = MeasureBaseJoins(mesh, BaseSurface::Make(mesh, CornerJoin::kRounded).value());
    EXPECT_EQ(paper.irregular_edges, static_cast<std::size_t>(2 * n));
    EXPECT_GT(paper.irregular_mean, 1e-2);
    EXPECT_LT(rounded.irregular_mean, 1e-6);
    EXPECT_LT(rounded.irregular_largest, 1e-5);
    EXPECT_LT(rounded.regular_largest, 1e-9);
    EXPECT_LT(rounded.largest_gap_mm, 1e-10);
    std::printf("%d directions: %.3e rad mean before, %.3e after\n", n, paper.irregular_mean, rounded.irregular_mean);
  }
}

TEST(BaseSurface, RoundedDerivativesAreThoseOfItsPoints) {
  const ControlMesh mesh = ControlMesh::Make(Raised("directions:3x2", 6.0)).value();
  const BaseSurface surface = BaseSurface::Make(mesh, CornerJoin::kRounded).value();
  for (PointIndex patch = 0; patch < static_cast<PointIndex>(mesh.size()); ++patch) {
    for (const double u : {0.11, 0.37, 0.9}) {
      for (const double v : {0.07, 0.55, 0.83}) {
        const double step = 1e-6;
        const PatchPoint at = surface.At(patch, u, v);
        const Vector3d du =
            (surface.At(patch, u + step, v).point - surface.At(patch, u - step, v).point) / (2.0 * step);
        const Vector3d dv =
            (surface.At(patch, u, v + step).point - surface.At(patch, u, v - step).point) / (2.0 * step);
        EXPECT_LT((at.du - du).norm(), 1e-6) << patch;
        EXPECT_LT((at.dv - dv).norm(), 1e-6) << patch;
      }
    }
  }
}

TEST(BaseSurface, ClosesTheCubeOfSixPatches) {
  QuadMesh cube;
  for (int k = 0; k < 8; ++k) cube.vertices.emplace_back(k & 1, (k >> 1) & 1, (k >> 2) & 1);
  cube.quads = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
  const ControlMesh mesh = ControlMesh::Make(ControlMeshOfQuads(cube).value(), FamilyRule::kCut).value();
  for (const CornerJoin join : {CornerJoin::kPaper, CornerJoin::kRounded}) {
    const BaseSurface surface = BaseSurface::Make(mesh, join).value();
    const BaseJoins joins = MeasureBaseJoins(mesh, surface);
    EXPECT_LT(joins.largest_gap_mm, 1e-12);
    if (join == CornerJoin::kRounded) {
      EXPECT_LT(joins.irregular_mean, 1e-6);
    }
    for (PointIndex patch = 0; patch < 6; ++patch) {
      const PatchPoint at = surface.At(patch, 0.5, 0.5);
      EXPECT_GT(surface.NormalAt(patch, at).dot(at.point - Vector3d(0.5, 0.5, 0.5)), 0.0);
    }
  }
}

TEST(BaseSurface, RefusesPatchesWithoutArea) {
  ControlMeshParts parts = MakeNet("regular:4x4").value();
  for (ControlPoint& point : parts.points) point.position.y() = 0.0;
  const ControlMesh mesh = ControlMesh::Make(parts).value();
  const auto made = BaseSurface::Make(mesh, CornerJoin::kPaper);
  ASSERT_FALSE(made);
  EXPECT_NE(made.error().Text().find("has no area"), std::string::npos);
}

}  // namespace
}  // namespace annulus
