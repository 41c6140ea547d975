#include "modeling/elastic/hex_element.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

#include "modeling/elastic/corotation.h"
#include "tests/modeling_elastic/elastic_check.h"

namespace annulus {
namespace {

using Eigen::Vector3d;

HexCorners Distorted(double amount) {
  HexCorners corners;
  for (int a = 0; a < 8; ++a) {
    corners.col(a) = 10.0 * Vector3d(a % 2, a / 2 % 2, a / 4);
    for (int c = 0; c < 3; ++c) corners(c, a) += amount * test::Wobble(static_cast<std::size_t>(3 * a + c + 1));
  }
  return corners;
}

TEST(HexElement, HasSixFreeMotionsAndNoOther) {
  for (const double poisson : {0.0, 0.3, 0.49}) {
    const auto stiffness = HexStiffness(Distorted(2.0), {1.0, poisson});
    ASSERT_TRUE(stiffness);
    EXPECT_LE((*stiffness - stiffness->transpose()).cwiseAbs().maxCoeff(), 1e-12);
    const Eigen::SelfAdjointEigenSolver<HexMatrix> eigen(*stiffness, Eigen::EigenvaluesOnly);
    const double largest = eigen.eigenvalues()[23];
    EXPECT_LE(std::abs(eigen.eigenvalues()[5]), 1e-12 * largest);
    EXPECT_LE(std::abs(eigen.eigenvalues()[0]), 1e-12 * largest);
    EXPECT_GE(eigen.eigenvalues()[6], 1e-4 * largest);
  }
}

TEST(HexElement, SaysNothingWhenInsideOut) {
  HexCorners corners = Distorted(0.0);
  corners.col(0) = Vector3d(25.0, 25.0, 25.0);
  EXPECT_FALSE(HexStiffness(corners, {1.0, 0.3}));
}

TEST(HexElement, GivesConstantStrainOnAnyShape) {
  const HexCorners corners = Distorted(2.0);
  Eigen::Matrix3d slope;
  slope << 0.01, 0.02, -0.005, 0.0, -0.015, 0.01, 0.007, 0.0, 0.02;
  const auto strains = HexStrains(corners, {1.0, 0.49}, slope * corners);
  Voigt expected;
  expected << 0.01, -0.015, 0.02, 0.02, 0.01, 0.002;
  for (const Voigt& strain : strains) EXPECT_LE((strain - expected).cwiseAbs().maxCoeff(), 1e-13);
}

TEST(HexElement, StressFollowsHookesLaw) {
  // Uniaxial tension: strains (1, -ν, -ν)·σ/E.
  Voigt strain;
  strain << 0.02, -0.006, -0.006, 0.0, 0.0, 0.0;
  const Voigt stress = StressOf(strain, {50.0, 0.3});
  EXPECT_NEAR(stress[0], 1.0, 1e-12);
  EXPECT_LE(stress.tail<5>().cwiseAbs().maxCoeff(), 1e-12);
}

TEST(TurnedElement, HasNoEnergyInAnyRotation) {
  const HexCorners rest = Distorted(2.0);
  const HexMatrix stiffness = *HexStiffness(rest, {1.0, 0.45});
  for (const double angle : {0.1, 1.0, 2.0, 3.0}) {
    const Eigen::Matrix3d turn = Eigen::AngleAxisd(angle, Vector3d(1.0, 2.0, -0.5).normalized()).toRotationMatrix();
    HexCorners current = turn * rest;
    current.colwise() += Vector3d(5.0, 6.0, 7.0);
    const TurnedElement element = Turned(stiffness, rest, current);
    EXPECT_LE(element.energy, 1e-20);
    EXPECT_LE((element.rotation - turn).cwiseAbs().maxCoeff(), 1e-12);
  }
}

/// A deformed element: stretched, sheared, bent and turned.
HexCorners Deformed(const HexCorners& rest) {
  Eigen::Matrix3d slope;
  slope << 1.2, 0.1, 0.0, -0.05, 0.85, 0.1, 0.0, 0.05, 1.1;
  HexCorners current = slope * rest;
  for (int a = 0; a < 8; ++a) current(2, a) += 0.02 * rest(0, a) * rest(0, a);
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(1.2, Vector3d(0.3, -1.0, 0.4).normalized()).toRotationMatrix();
  return turn * current;
}

TEST(TurnedElement, ForceIsTheDerivativeOfItsEnergy) {
  const HexCorners rest = Distorted(1.0);
  const HexMatrix stiffness = *HexStiffness(rest, {1.0, 0.4});
  const HexCorners current = Deformed(rest);
  const TurnedElement element = Turned(stiffness, rest, current);
  const HexCorners force = element.rotation * element.force;
  const HexMatrix tangent = ElementTangent(stiffness, element, ElasticTangent::kFull);
  constexpr double kStep = 1e-4;
  HexMatrix expected;
  for (int k = 0; k < 24; ++k) {
    HexCorners plus = current;
    HexCorners minus = current;
    plus.data()[k] += kStep;
    minus.data()[k] -= kStep;
    const TurnedElement more = Turned(stiffness, rest, plus);
    const TurnedElement less = Turned(stiffness, rest, minus);
    EXPECT_NEAR((more.energy - less.energy) / (2.0 * kStep), force.data()[k], 1e-6);
    const HexCorners change = (more.rotation * more.force - less.rotation * less.force) / (2.0 * kStep);
    expected.col(k) = Eigen::Map<const Eigen::Matrix<double, 24, 1>>(change.data());
  }
  // The tangent leaves out how the spin itself changes: little even at a stretch of 20 %.
  EXPECT_LE((tangent - expected).norm(), 0.02 * expected.norm());
}

TEST(TurnedElement, InnerForcesHaveNoMoment) {
  const HexCorners rest = Distorted(1.0);
  const HexMatrix stiffness = *HexStiffness(rest, {1.0, 0.4});
  const TurnedElement element = Turned(stiffness, rest, Deformed(rest));
  Vector3d moment = Vector3d::Zero();
  double size = 0.0;
  for (int a = 0; a < 8; ++a) {
    const Vector3d one = Vector3d(element.turned_back.col(a)).cross(Vector3d(element.force.col(a)));
    moment += one;
    size += one.norm();
  }
  EXPECT_LE(moment.norm(), 1e-10 * size);
}

}  // namespace
}  // namespace annulus
