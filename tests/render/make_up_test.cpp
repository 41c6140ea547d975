#include "render/make_up.h"

#include <gtest/gtest.h>

#include <cmath>

#include "modeling/mesh/tessellate.h"
#include "sim/random_head.h"
#include "tests/support/head_surface.h"

namespace annulus {
namespace {

using Eigen::Vector3d;

/// A simulated head, what was searched on it, and its mesh.
struct MadeUpHead {
  sim::HeadVariation variation;
  SurfaceModel model;
  FacePoints face;
  MakeUpZones zones;
  TriangleMesh mesh;

  static MadeUpHead Of(std::uint64_t seed) {
    const sim::HeadVariation variation = sim::DrawHeadVariation(seed);
    SurfaceModel model = test::HeadSurface(sim::MakeVariedHead(variation));
    const FacePoints face = *FindFacePoints(model.main().surface);
    const MakeUpZones zones = MakeUpZones::On(model.main().surface, face);
    const TriangleMesh mesh = TessellateSurface(model.main(), {.theta_count = 360, .max_z_spacing_mm = 1.5});
    return {variation, std::move(model), face, zones, mesh};
  }
};

const LinearRgb kSkin = LinearFromHex(0xdfb8a0);
const LinearRgb kRed = LinearFromHex(0x9c1f2e);

TEST(MakeUp, FindsTheMouthWhereTheSimulatedHeadHasIt) {
  // sim/varied_head.cpp builds lips 67 and 76 mm below the eyes and the crease between them 71.5 mm below, times size.
  for (const std::uint64_t seed : {1, 2, 3, 4}) {
    const MadeUpHead head = MadeUpHead::Of(seed);
    const Mouth& mouth = head.zones.mouth();
    EXPECT_EQ(mouth.source, LandmarkSource::kDetected) << seed;
    EXPECT_NEAR(mouth.stomion, head.variation.eye_z - 71.5 * head.variation.size, 1.5) << seed;
    for (const double half : mouth.half_breadth) EXPECT_NEAR(half, 24.0, 6.0) << seed;
    EXPECT_NEAR(mouth.upper_height, 6.5, 2.0) << seed;
    EXPECT_NEAR(mouth.lower_height, 8.0, 2.5) << seed;
  }
}

TEST(MakeUp, WithoutStrengthNothingIsLaid) {
  const MadeUpHead head = MadeUpHead::Of(3);
  MakeUp make_up;
  make_up.lips.colour = kRed;
  EXPECT_TRUE(MakeUpColours(head.zones, make_up, kSkin, head.mesh.vertices).empty());
}

TEST(MakeUp, LiesOnTheFrontOfTheFaceOnly) {
  const MadeUpHead head = MadeUpHead::Of(3);
  const double eyes = head.variation.eye_z;
  double lips = 0.0;
  double brows = 0.0;
  for (const Vector3d& p : head.mesh.vertices) {
    const MakeUpCover cover = head.zones.At(p);
    if (cover.lips + cover.cheeks + cover.brows > 0.0) {
      EXPECT_GT(p.y(), 0.0);
    }
    if (cover.lips > 0.0) {
      EXPECT_NEAR(p.z(), eyes - 71.5 * head.variation.size, 16.0);
    }
    if (cover.brows > 0.0) {
      EXPECT_GT(p.z(), eyes + 8.0);
      EXPECT_LT(p.z(), eyes + 32.0);
    }
    lips = std::max(lips, cover.lips);
    brows = std::max(brows, cover.brows);
    for (const double share : {cover.lips, cover.cheeks, cover.brows}) EXPECT_TRUE(share >= 0.0 && share <= 1.0);
  }
  EXPECT_GT(lips, 0.99);
  EXPECT_GT(brows, 0.99);
}

TEST(MakeUp, LipsCoverAsMuchSkinAsLipsDo) {
  const MadeUpHead head = MadeUpHead::Of(2);
  double area = 0.0;
  for (const auto& face : head.mesh.faces) {
    const Vector3d& a = head.mesh.vertices[face[0]];
    const Vector3d& b = head.mesh.vertices[face[1]];
    const Vector3d& c = head.mesh.vertices[face[2]];
    const double cover = (head.zones.At(a).lips + head.zones.At(b).lips + head.zones.At(c).lips) / 3.0;
    area += 0.5 * (b - a).cross(c - a).norm() * cover;
  }
  EXPECT_GT(area, 250.0);  // mm²; a lip is about 45 mm broad, 6 and 8 mm high in the middle
  EXPECT_LT(area, 800.0);
}

TEST(MakeUp, WhereItCoversWhollyTheColourIsTheLayers) {
  const MadeUpHead head = MadeUpHead::Of(3);
  MakeUp make_up;
  make_up.lips = {kRed, 1.0};
  const auto factors = MakeUpColours(head.zones, make_up, kSkin, head.mesh.vertices);
  ASSERT_EQ(factors.size(), head.mesh.vertices.size());
  int covered = 0;
  for (std::size_t k = 0; k < factors.size(); ++k) {
    const double cover = head.zones.At(head.mesh.vertices[k]).lips;
    const LinearRgb colour = kSkin.cwiseProduct(factors[k]);
    if (cover == 0.0) {
      EXPECT_EQ(factors[k], LinearRgb::Ones());
    }
    if (cover < 1.0) continue;
    ++covered;
    EXPECT_TRUE(colour.isApprox(kRed, 1e-5F));
  }
  EXPECT_GT(covered, 20);
}

TEST(MakeUp, StaysFiniteOnABlackSkin) {
  const MadeUpHead head = MadeUpHead::Of(3);
  MakeUp make_up;
  make_up.cheeks = {LinearRgb::Ones(), 1.0};
  make_up.brows = {kRed, 0.5};
  for (const LinearRgb& factor : MakeUpColours(head.zones, make_up, LinearRgb::Zero(), head.mesh.vertices)) {
    EXPECT_TRUE(factor.allFinite() && factor.minCoeff() >= 0.0F);
  }
}

TEST(MakeUp, EdgesAreSoft) {
  // No two neighbours of a mesh with cells under 2 mm differ by more than the 2 mm of an edge allow.
  const MadeUpHead head = MadeUpHead::Of(3);
  for (const auto& face : head.mesh.faces) {
    for (std::size_t k = 0; k < 3; ++k) {
      const Vector3d& a = head.mesh.vertices[face[k]];
      const Vector3d& b = head.mesh.vertices[face[(k + 1) % 3]];
      const double apart = (a - b).norm();
      if (apart > 1.0) continue;
      EXPECT_LE(std::abs(head.zones.At(a).brows - head.zones.At(b).brows), 0.95);
      EXPECT_LE(std::abs(head.zones.At(a).cheeks - head.zones.At(b).cheeks), 0.15);
    }
  }
}

}  // namespace
}  // namespace annulus
