#include "modeling/bezier/shell_solids.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <vector>

#include "base/units.h"
#include "modeling/bezier/tube_chain.h"

namespace annulus {
namespace {

using Eigen::Vector3d;

Eigen::Isometry3d SomePose() {
  return Eigen::Translation3d(3.0, -2.0, 5.0) * Eigen::AngleAxisd(0.7, Vector3d(1.0, 2.0, -0.5).normalized());
}

void ExpectClosed(const PatchShell& shell) {
  const ShellJoins joins = MeasureJoins(shell);
  EXPECT_EQ(joins.open_edges, 0U) << shell.name;
  EXPECT_LT(joins.position_gap, 1e-9) << shell.name;
  EXPECT_EQ(CountOpenEdges(Tessellate(shell, {})), 0U) << shell.name;
}

TEST(ShellSolids, BoxHoldsItsSidesProduct) {
  const PatchShell box = BoxShell("box", SomePose(), {1.0, 2.0, 1.5});
  ExpectClosed(box);
  const ShellMoments moments = MomentsOf(box);
  EXPECT_NEAR(moments.volume, 2.0 * 4.0 * 3.0, 1e-9);
  EXPECT_LT((moments.first / moments.volume - Vector3d(3.0, -2.0, 5.0)).norm(), 1e-9);
}

TEST(ShellSolids, RingHoldsItsAnnulusTimesItsHeight) {
  const PatchShell ring =
      TurnedShell("ring", SomePose(), {{2.0, -1.0}, {3.0, -1.0}, {3.0, 1.5}, {2.0, 1.5}}, ProfileEnds::kLoop);
  ExpectClosed(ring);
  // Cubic quarters hold 2.8e-4 more than circles.
  EXPECT_NEAR(Volume(ring) / (kPi * 5.0 * 2.5), 1.0, 5e-4);
}

TEST(ShellSolids, TurnedSolidWithDiscsIsTheSumOfItsCylinders) {
  const PatchShell mount =
      TurnedShell("mount", SomePose(), {{2.0, 3.0}, {2.0, 2.0}, {0.5, 2.0}, {0.5, 0.0}}, ProfileEnds::kDiscs);
  ExpectClosed(mount);
  EXPECT_NEAR(Volume(mount) / (kPi * (4.0 * 1.0 + 0.25 * 2.0)), 1.0, 5e-4);
  // The same profile the other way round.
  const PatchShell turned =
      TurnedShell("mount", SomePose(), {{0.5, 0.0}, {0.5, 2.0}, {2.0, 2.0}, {2.0, 3.0}}, ProfileEnds::kDiscs);
  EXPECT_NEAR(Volume(turned), Volume(mount), 1e-9);
}

TEST(PatchShell, MirroredShellKeepsVolumeAndMirrorsItsCentre) {
  const PatchShell ring =
      TurnedShell("ring", SomePose(), {{2.0, -1.0}, {3.0, -1.0}, {3.0, 1.5}, {2.0, 1.5}}, ProfileEnds::kLoop);
  const PatchShell mirrored = MirroredX(ring, "other");
  EXPECT_EQ(mirrored.name, "other");
  const ShellMoments here = MomentsOf(ring);
  const ShellMoments there = MomentsOf(mirrored);
  EXPECT_NEAR(there.volume, here.volume, 1e-9);
  EXPECT_LT((there.first - here.first.cwiseProduct(Vector3d(-1, 1, 1))).norm(), 1e-9);
  ExpectClosed(mirrored);
}

TEST(BezierPatch, CoonsPatchKeepsItsEdgesAndReproducesABilinearSheet) {
  const auto sheet = [](double u, double v) -> Vector3d { return {u, v, 0.3 * u * v + 0.1 * u - 0.2 * v}; };
  const PatchEdges edges{StraightCurve(sheet(0, 0), sheet(0, 1)), StraightCurve(sheet(1, 0), sheet(1, 1)),
                         StraightCurve(sheet(0, 0), sheet(1, 0)), StraightCurve(sheet(0, 1), sheet(1, 1))};
  const BezierPatch patch = CoonsPatch(edges);
  for (double u = 0.0; u <= 1.0; u += 0.25) {
    for (double v = 0.0; v <= 1.0; v += 0.25) EXPECT_LT((patch.Point(u, v) - sheet(u, v)).norm(), 1e-12);
  }
}

TEST(BezierCurve, QuarterCirclesLengthIsItsArc) {
  const double k = 4.0 / 3.0 * (std::sqrt(2.0) - 1.0);
  const BezierCurve quarter{Vector3d(1, 0, 0), Vector3d(1, k, 0), Vector3d(k, 1, 0), Vector3d(0, 1, 0)};
  EXPECT_NEAR(CubicBezierLength(quarter), kPi / 2.0, 3e-4);  // The cubic is up to 0.027 % too large.
  const auto [low, high] = Split(quarter, 0.3);
  EXPECT_NEAR(CubicBezierLength(low) + CubicBezierLength(high), CubicBezierLength(quarter), 1e-9);
  EXPECT_LT((CubicBezierPoint(Backwards(quarter), 0.3) - CubicBezierPoint(quarter, 0.7)).norm(), 1e-15);
}

TEST(TubeChain, TubesThatShareAJetJoinWithG1) {
  const TubeJet a{{0, 0, 0}, Vector3d(1, 0, 0), {0, 0, 1.0}, {0, -1.0, 0}, {0, 0, 0.05}};
  const TubeJet b{{10, 3, 1}, Vector3d(0.6, 0.8, 0), {0, 0, 1.5}, {0.8, -0.6, 0}, {0, 0, -0.02}};
  const TubeJet c{{14, 12, 0}, Vector3d(0, 1, 0), {0, 0, 1.2}, {1.0, 0, 0}};
  EXPECT_LT(LargestKink({HermiteTube(a, b, 2.0, 4.0), HermiteTube(b, c, 1.0, 3.0)}), 1e-12);
  // Reversing does not change that, nor the solid.
  const std::vector<BezierTube> chain{HermiteTube(a, b), HermiteTube(b, c)};
  EXPECT_LT(LargestKink(Reversed(chain)), 1e-12);
  const double volume = Volume(ShellOfTubes("there", chain, TubeEnds::kCapped));
  EXPECT_NEAR(Volume(ShellOfTubes("back", Reversed(chain), TubeEnds::kCapped)), volume, 1e-9);
  EXPECT_NEAR(Volume(ShellOfTubes("mirrored", MirroredX(chain), TubeEnds::kCapped)), volume, 1e-9);
}

TEST(TubeChain, KinkIsFound) {
  const TubeJet a{{0, 0, 0}, Vector3d(1, 0, 0), {0, 0, 1.0}, {0, -1.0, 0}};
  TubeJet b{{10, 0, 0}, Vector3d(1, 0, 0), {0, 0, 1.0}, {0, -1.0, 0}};
  const BezierTube first = HermiteTube(a, b);
  b.tangent = {std::cos(0.02), std::sin(0.02), 0.0};
  const TubeJet c{{20, 0, 0}, Vector3d(1, 0, 0), {0, 0, 1.0}, {0, -1.0, 0}};
  EXPECT_NEAR(LargestKink({first, HermiteTube(b, c)}), 0.02, 1e-6);
}

TEST(TubeChain, RoundStartIsClosedAndSmooth) {
  const TubeJet end{{0, 0, 0}, Vector3d(1, 0, 0), {0, 0, 2.0}, {0, -1.5, 0}};
  const TubeJet far{{10, 0, 0}, Vector3d(1, 0, 0), {0, 0, 2.0}, {0, -1.5, 0}};
  const std::vector<BezierTube> chain{RoundStart(end, 2.0), HermiteTube(end, far)};
  EXPECT_LT(LargestKink(chain), 1e-9);
  const PatchShell shell = ShellOfTubes("round", chain, TubeEnds::kCapped);
  ExpectClosed(shell);
  // Section 2.4·(half width)(half depth); the round end is a quarter of an ellipse turned into a solid, 2/3 of its
  // length (2.8e-4 more for the cubic).
  EXPECT_NEAR(Volume(shell) / (2.4 * 2.0 * 1.5 * (10.0 + 2.0 * 2.0 / 3.0)), 1.0, 1e-3);
}

}  // namespace
}  // namespace annulus
