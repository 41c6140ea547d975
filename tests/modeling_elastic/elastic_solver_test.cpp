#include "modeling/elastic/elastic_solver.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>

#include "modeling/elastic/skin_maps.h"
#include "tests/modeling_elastic/elastic_check.h"

namespace annulus {
namespace {

using Eigen::Vector3d;
using test::Block;
using test::HoldNode;
using test::RadialMovement;
using test::Tube;

ElasticOptions With(ElasticMethod method) {
  ElasticOptions options;
  options.method = method;
  options.tolerance = 1e-11;
  return options;
}

/// Every step lowers the energy (but for rounding).
void ExpectDescent(const ElasticSolution& solution) {
  for (std::size_t n = 1; n < solution.potential.size(); ++n) {
    EXPECT_LE(solution.potential[n], solution.potential[n - 1] + 1e-12 * std::abs(solution.potential[n - 1]));
  }
}

/// A block of distorted elements whose surface is moved linearly.
ElasticProblem Patch(const Eigen::Matrix3d& slope, double poisson) {
  const GridShape shape{4, 4, 4, GridClosure::kOpen};
  ElasticProblem problem = Block(shape, Vector3d(30.0, 24.0, 36.0), {2.0, poisson});
  for (std::size_t n = 0; n < problem.grid.nodes.size(); ++n) {
    const std::size_t k = n % 4;
    const std::size_t i = n / 4 % 4;
    const std::size_t j = n / 16;
    const bool inside = i % 3 != 0 && j % 3 != 0 && k % 3 != 0;
    if (inside) {
      for (std::size_t c = 0; c < 3; ++c) problem.grid.nodes[n][static_cast<int>(c)] += 2.0 * test::Wobble(3 * n + c);
    } else {
      HoldNode(problem, n, slope * problem.grid.nodes[n]);
    }
  }
  return problem;
}

TEST(ElasticSolver, PassesThePatchTest) {
  Eigen::Matrix3d slope;
  slope << 0.01, 0.02, -0.005, 0.0, -0.015, 0.01, 0.007, 0.0, 0.02;
  for (const double poisson : {0.3, 0.49}) {
    const ElasticProblem problem = Patch(slope, poisson);
    const auto solution = SolveElastic(problem, With(ElasticMethod::kLinear), {});
    ASSERT_TRUE(solution) << solution.error().Text();
    for (std::size_t n = 0; n < problem.grid.nodes.size(); ++n) {
      EXPECT_LE((solution->displacement[n] - slope * problem.grid.nodes[n]).norm(), 1e-10);
    }
    Voigt strain;
    strain << 0.01, -0.015, 0.02, 0.02, 0.01, 0.002;
    const Voigt stress = StressOf(strain, problem.material);
    for (const Voigt& found : StatesOf(problem, *solution, 4, 1).stress) {
      EXPECT_LE((found - stress).cwiseAbs().maxCoeff(), 1e-10);
    }
  }
}

TEST(ElasticSolver, TurnsAPatchWithoutStress) {
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(1.2, Vector3d(1.0, 1.0, 0.5).normalized()).toRotationMatrix();
  const ElasticProblem problem = Patch(turn - Eigen::Matrix3d::Identity(), 0.49);
  const auto solution = SolveElastic(problem, With(ElasticMethod::kCorotational), {});
  ASSERT_TRUE(solution) << solution.error().Text();
  for (std::size_t n = 0; n < problem.grid.nodes.size(); ++n) {
    const Vector3d expected = turn * problem.grid.nodes[n] - problem.grid.nodes[n];
    EXPECT_LE((solution->displacement[n] - expected).norm(), 1e-8);
  }
  ExpectDescent(*solution);
}

TEST(ElasticSolver, MeetsLameInAThickCylinder) {
  constexpr double kInner = 50.0;
  constexpr double kOuter = 100.0;
  constexpr double kHeight = 8.0;
  constexpr double kPressure = 0.001;
  for (const double poisson : {0.3, 0.49}) {
    const ElasticMaterial material{0.02, poisson};
    ElasticProblem problem = Tube(48, 9, kInner, kOuter, kHeight, material);
    NodePull push;
    for (std::size_t stack = 0; stack < 96; ++stack) {
      const std::size_t node = stack * 9;
      const Vector3d out(problem.grid.nodes[node].x() / kInner, problem.grid.nodes[node].y() / kInner, 0.0);
      push.entries.push_back({node, 2.0 * std::numbers::pi * kInner / 48.0 * 0.5 * kHeight * out});
    }
    push.force = kPressure;
    problem.pulls.push_back(push);
    const auto solution = SolveElastic(problem, With(ElasticMethod::kLinear), {});
    ASSERT_TRUE(solution) << solution.error().Text();
    // Lamé, plane strain: u(r) = (1 + ν)/E · p a²/(b² − a²) · ((1 − 2ν) r + b²/r).
    const double share = kPressure * kInner * kInner / (kOuter * kOuter - kInner * kInner);
    const auto lame = [&](double r) {
      return (1.0 + poisson) / material.young * share * ((1.0 - 2.0 * poisson) * r + kOuter * kOuter / r);
    };
    EXPECT_NEAR(RadialMovement(problem, *solution, 0) / lame(kInner), 1.0, 0.01) << poisson;
    EXPECT_NEAR(RadialMovement(problem, *solution, 8) / lame(kOuter), 1.0, 0.01) << poisson;
    // Von Mises of σ_r, σ_θ = share·(1 ∓ b²/r²), σ_z = 2ν·share, half way.
    const double ratio = kOuter * kOuter / (75.0 * 75.0);
    Voigt stress = Voigt::Zero();
    stress.head<3>() = share * Vector3d(1.0 - ratio, 1.0 + ratio, 2.0 * poisson);
    const CornerStates states = StatesOf(problem, *solution, 5, 4);
    const CornerStates inner = StatesOf(problem, *solution, 5, 3);
    EXPECT_NEAR(0.5 * (VonMises(states.stress[0]) + VonMises(inner.stress[4])) / VonMises(stress), 1.0, 0.01);
  }
}

/// A beam along x, held at x = 0 so that it may grow thinner there as beam theory has it, with forces along z at its
/// end that add up to `force`.
ElasticProblem Cantilever(double length, double side, std::size_t cells, const ElasticMaterial& material,
                          double force) {
  const GridShape shape{cells + 1, 3, 3, GridClosure::kOpen};
  ElasticProblem problem = Block(shape, Vector3d(length, side, side), material);
  NodePull push;
  for (std::size_t j = 0; j < 3; ++j) {
    for (std::size_t k = 0; k < 3; ++k) {
      const std::size_t end = problem.grid.Node(0, j, k);
      problem.held[3 * end] = 1;
      problem.held[3 * end + 1] = j == 1 ? 1 : 0;
      problem.held[3 * end + 2] = k == 1 ? 1 : 0;
      const double share = (j == 1 ? 0.5 : 0.25) * (k == 1 ? 0.5 : 0.25);
      push.entries.push_back({problem.grid.Node(cells, j, k), Vector3d(0.0, 0.0, share)});
    }
  }
  push.force = force;
  problem.pulls.push_back(push);
  return problem;
}

TEST(ElasticSolver, BendsACantileverAsTimoshenkoSays) {
  constexpr double kLength = 200.0;
  constexpr double kSide = 10.0;
  for (const double poisson : {0.0, 0.3, 0.49}) {
    const ElasticMaterial material{10.0, poisson};
    const ElasticProblem problem = Cantilever(kLength, kSide, 40, material, 1e-3);
    const auto solution = SolveElastic(problem, With(ElasticMethod::kLinear), {});
    ASSERT_TRUE(solution) << solution.error().Text();
    const double inertia = std::pow(kSide, 4) / 12.0;
    const double shear = 10.0 * (1.0 + poisson) / (12.0 + 11.0 * poisson);  // Cowper 1966, rectangle
    const double expected = 1e-3 * (std::pow(kLength, 3) / (3.0 * material.young * inertia) +
                                    kLength / (shear * material.mu() * kSide * kSide));
    EXPECT_NEAR(solution->displacement[problem.grid.Node(40, 1, 1)].z() / expected, 1.0, 0.01) << poisson;
  }
}

TEST(ElasticSolver, BendsACantileverFarAsTheElasticaSays) {
  // Elastica with P L²/(E I) = 2, by scipy:
  //   from scipy.integrate import solve_bvp; import numpy as np
  //   s = np.linspace(0, 1, 401)
  //   r = solve_bvp(lambda s, y: np.vstack((y[1], -2*np.cos(y[0]))), lambda a, b: np.array([a[0], b[1]]), s,
  //                 np.vstack((s, 1 - s)), tol=1e-10)
  //   print(np.trapz(np.sin(r.sol(s)[0]), s), 1 - np.trapz(np.cos(r.sol(s)[0]), s))
  // gives 0.49346 and 0.16064 (as Mattiasson 1981).
  constexpr double kLength = 400.0;
  constexpr double kSide = 10.0;
  const ElasticMaterial material{10.0, 0.0};
  const double inertia = std::pow(kSide, 4) / 12.0;
  const ElasticProblem problem =
      Cantilever(kLength, kSide, 60, material, 2.0 * material.young * inertia / (kLength * kLength));
  ElasticOptions options = With(ElasticMethod::kCorotational);
  options.tolerance = 1e-8;
  const auto solution = SolveElastic(problem, options, {});
  ASSERT_TRUE(solution) << solution.error().Text();
  EXPECT_EQ(solution->termination, "converged");
  const Vector3d tip = solution->displacement[problem.grid.Node(60, 1, 1)];
  EXPECT_NEAR(tip.z() / kLength / 0.49346, 1.0, 0.01);
  EXPECT_NEAR(-tip.x() / kLength / 0.16064, 1.0, 0.01);
  ExpectDescent(*solution);
}

TEST(ElasticSolver, FindsTheForceOfAGivenMovement) {
  ElasticProblem problem = Cantilever(100.0, 10.0, 10, {10.0, 0.3}, 2e-3);
  const auto forced = SolveElastic(problem, With(ElasticMethod::kLinear), {});
  ASSERT_TRUE(forced);
  problem.pulls[0].movement = forced->pull_movement[0];
  problem.pulls[0].force = 0.0;
  const auto moved = SolveElastic(problem, With(ElasticMethod::kLinear), {});
  ASSERT_TRUE(moved);
  EXPECT_NEAR(moved->pull_force[0] / 2e-3, 1.0, 1e-4);
  EXPECT_NEAR(moved->pull_movement[0] / forced->pull_movement[0], 1.0, 1e-4);
}

TEST(ElasticSolver, RefusesWhatCannotBe) {
  EXPECT_FALSE(SolveElastic(Cantilever(100.0, 10.0, 5, {10.0, 0.5}, 1.0), {}, {}));
  EXPECT_FALSE(SolveElastic(Cantilever(100.0, 10.0, 5, {-1.0, 0.3}, 1.0), {}, {}));
  ElasticProblem loose = Cantilever(100.0, 10.0, 5, {10.0, 0.3}, 1.0);
  std::fill(loose.held.begin(), loose.held.end(), char{0});
  EXPECT_FALSE(SolveElastic(loose, With(ElasticMethod::kLinear), {}));
  ElasticProblem folded = Cantilever(100.0, 10.0, 5, {10.0, 0.3}, 1.0);
  folded.grid.nodes[13] += Vector3d(0.0, 0.0, 50.0);
  EXPECT_FALSE(SolveElastic(folded, {}, {}));
}

}  // namespace
}  // namespace annulus
