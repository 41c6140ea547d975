#include "modeling/clay/clay_body.h"

#include <gtest/gtest.h>

#include <cmath>

#include "modeling/clay/clay_field.h"
#include "modeling/clay/clay_region.h"
#include "modeling/clay/clay_shapes.h"
#include "modeling/clay/clay_stroke.h"
#include "modeling/clay/patch_volume.h"
#include "tests/modeling_clay/clay_check.h"

namespace annulus {
namespace {

using Eigen::Vector3d;

ClayBody Body(const PatchShell& shell) {
  auto body = ClayBody::Make(shell);
  EXPECT_TRUE(body) << (body ? "" : body.error().Text());
  return std::move(*body);
}

TEST(ClayBody, MeasuresABlock) {
  const ClayBody body = Body(ClayBlock(6.0, 3.0, 6, 3));
  EXPECT_NEAR(body.volume(), 108.0, 1e-12);
  EXPECT_NEAR(body.Area(), 2.0 * 36.0 + 4.0 * 18.0, 1e-12);
}

TEST(ClayBody, MeasuresTheTeapot) {
  const ClayBody body = Body(UtahTeapot());
  // numpy, Gauss–Legendre with 12 nodes each way over the same control points: pot 25.26577056628571, handle
  // 0.2629800000000003, spout 0.6559882499999999.
  EXPECT_NEAR(body.volume(), 26.18473881628571, 1e-13);
  EXPECT_EQ(test::Unsound(body.mesh(), 1e-12), "");
}

TEST(ClayBody, RefusesASkinThatIsInsideOut) {
  PatchShell shell = ClayBlock();
  for (ShellPatch& piece : shell.patches) piece.patch = piece.patch.Flipped();
  const auto body = ClayBody::Make(shell);
  ASSERT_FALSE(body);
  EXPECT_NE(body.error().seen.find("its volume is -108"), std::string::npos) << body.error().Text();
}

/// The top's middle pushed down by a dent of closed form, all control points moved by the affine groups.
ClayStroke DentStroke(const ClayBody& body, double depth, double radius, double rho) {
  const ClayAddress at{21, 0.0, 0.0};  // the corner in the middle of the top
  ToolPlace place;
  place.origin = body.Point(at);
  place.out = Vector3d::UnitZ();
  place.along = Vector3d::UnitX();
  place.radius_along = place.radius_across = radius;
  place.reach = 4.0 * depth;
  ClayStroke stroke;
  stroke.places.push_back({at, place.origin, rho * radius, 0.25 * radius});
  stroke.direct = DentField(place, depth);
  stroke.indirect = RimField(place, rho);
  return stroke;
}

TEST(ClayBody, RimsADentAsHighAsTheVolumesSay) {
  ClayBody body = Body(ClayBlock());
  const double radius = 1.0;
  const double rho = 2.0;
  const double depth = 0.1;
  const auto change = Carry(body, DentStroke(body, depth, radius, rho), MaskWeight(body, {}));
  ASSERT_TRUE(change) << change.error().Text();
  // On a flat sheet both fields are heights, and k is the quotient of their integrals; scipy:
  //   s = lambda t: np.clip(t,0,1)**3*(10-15*np.clip(t,0,1)+6*np.clip(t,0,1)**2)
  //   dent = quad(lambda q: (1-s((q*q-.75)/.5))*(1-q*q)*q, 0, 2)[0]
  //   rim = quad(lambda q: s((q*q-.75)/.5)*(1-q*q/4)*(1-s((q*q-2.4)/1.6))*q, 0, 2)[0]
  //   .1*dent/rim
  // 0.1 · 0.24776785714285715 / 0.51734375; the groups follow the fields at their corners only: within 2 %.
  EXPECT_NEAR(change->k, 0.04789230702851966, 0.001);
  EXPECT_LE(std::abs(body.volume() / 108.0 - 1.0), 1e-14);
  EXPECT_NEAR(body.Point({21, 0.0, 0.0}).z(), -depth, 1e-12);
  EXPECT_EQ(test::Unsound(body.mesh(), 1e-12), "");
}

TEST(ClayBody, ScalesBackToItsVolume) {
  ClayBody body = Body(ClayBlock());
  ClayStroke stroke = DentStroke(body, 0.2, 1.0, 2.0);
  stroke.indirect = {};
  const auto change = Carry(body, stroke, MaskWeight(body, {}));
  ASSERT_TRUE(change) << change.error().Text();
  EXPECT_GT(change->k, 0.0);
  EXPECT_LE(std::abs(body.volume() / 108.0 - 1.0), 1e-14);
  // All cones anew: what was scaled is what would be computed.
  PairwiseSum cones;
  for (PatchIndex index = 0; index < body.mesh().patches().size(); ++index) {
    if (body.mesh().alive(index)) cones.Set(index, ConeVolume(body.mesh().patch(index).net, Vector3d::Zero()));
  }
  EXPECT_LE(std::abs(cones.total() / 108.0 - 1.0), 1e-13);
}

TEST(ClayBody, RefusesWhatWouldCrossAndStaysAsItWas) {
  ClayBody body = Body(ClayBlock(6.0, 0.5, 6, 1));
  const double before = body.volume();
  ClayStroke stroke = DentStroke(body, 0.8, 1.0, 2.0);
  const auto change = Carry(body, stroke, MaskWeight(body, {}));
  ASSERT_FALSE(change);
  EXPECT_NE(change.error().seen.find("would cross"), std::string::npos) << change.error().Text();
  EXPECT_NEAR(body.volume(), before, 1e-13);
  EXPECT_NEAR(body.Point({21, 0.0, 0.0}).z(), 0.0, 1e-15);
}

TEST(ClayBody, RefusesPatchesThatCrossTheirNeighbours) {
  // A cube, three patches wide. The middle of its side x = 3 is bent in, upwards over the edge and back down through
  // the top, which it shares that edge with: in x and z a cubic from (3, 0) by (0, 1.8) and (1, −4) to (3, −6), through
  // z = 0 near x = 1.4.
  ClayBody body = Body(ClayBlock(6.0, 6.0, 3, 1));
  ClayDeformation deformation;
  for (VertexIndex vertex = 0; vertex < body.mesh().vertex_slots(); ++vertex) {
    const Vector3d place = body.mesh().Position(vertex);
    if (place.x() < 2.0 || std::abs(place.y()) > 2.0) continue;
    Eigen::Matrix3d gradient = Eigen::Matrix3d::Zero();
    gradient.col(2) = place.z() > -3.0 ? Vector3d(1.5, 0.0, -1.9) : Vector3d(-1.0, 0.0, 0.0);
    deformation.direct.push_back({vertex, Vector3d::Zero(), gradient});
  }
  const auto change = body.Deform(deformation, VolumeRule::kFreed);
  ASSERT_FALSE(change);
  EXPECT_NE(change.error().seen.find("would cross"), std::string::npos) << change.error().Text();
  // Half of it only bends the side.
  for (GroupMotion& motion : deformation.direct) motion.gradient.col(2) *= 0.4;
  EXPECT_TRUE(body.Deform(deformation, VolumeRule::kFreed));
}

/// Nets of all leaves, in order.
std::vector<BezierPatch::ControlNet> NetsOf(const ClayBody& body) {
  std::vector<BezierPatch::ControlNet> nets;
  for (const PatchIndex leaf : body.mesh().LeavesInOrder()) nets.push_back(body.mesh().patch(leaf).net);
  return nets;
}

TEST(ClayBody, CoarsensWithinItsToleranceAndRestoresToTheBit) {
  ClayBody body = Body(test::RoundBlock());
  ASSERT_TRUE(Carry(body, DentStroke(body, 0.05, 1.0, 2.0), MaskWeight(body, {})));
  const auto before = NetsOf(body);
  const double volume = body.volume();
  const Vector3d place = body.Point({21, 0.3, 0.2});
  const auto former = body.Coarsen(WholeBody(body.mesh()).patches, 0.6, 0.02);
  EXPECT_LT(body.mesh().leaf_count(), before.size());
  EXPECT_EQ(test::Unsound(body.mesh(), 1e-9), "");
  EXPECT_NE(body.volume(), volume);
  EXPECT_LE((body.Point({21, 0.3, 0.2}) - place).norm(), 0.03);
  body.Restore(former);
  EXPECT_EQ(NetsOf(body), before);
  EXPECT_NEAR(body.volume(), volume, 1e-14 * volume);
}

TEST(ClayBody, RefusesWhatNothingTakesUp) {
  ClayBody body = Body(ClayBlock());
  ClayStroke stroke = DentStroke(body, 0.2, 1.0, 2.0);
  stroke.indirect = [](const Vector3d&) { return PointMotion{}; };
  const auto change = Carry(body, stroke, MaskWeight(body, {}));
  ASSERT_FALSE(change);
  EXPECT_NE(change.error().seen.find("nothing takes up"), std::string::npos) << change.error().Text();
}

TEST(ClayBody, HoldsStillUnderAMask) {
  ClayBody body = Body(ClayBlock());
  const ClayAddress beside{23, 0.5, 0.5};
  const Vector3d before = body.Point(beside);
  ClayStroke stroke = DentStroke(body, 0.2, 1.0, 4.0);
  const auto change = Carry(body, stroke, MaskWeight(body, {{beside, 0.7}}));
  ASSERT_TRUE(change) << change.error().Text();
  EXPECT_LT((body.Point(beside) - before).norm(), 1e-12);
  EXPECT_LE(std::abs(body.volume() / 108.0 - 1.0), 1e-14);
}

}  // namespace
}  // namespace annulus
