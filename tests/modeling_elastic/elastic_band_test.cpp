#include <gtest/gtest.h>

#include <numbers>

#include "modeling/elastic/band_fibre.h"
#include "modeling/elastic/skin_maps.h"
#include "tests/modeling_elastic/elastic_check.h"

namespace annulus {
namespace {

using Eigen::Vector3d;
using test::RadialMovement;
using test::Tube;

constexpr double kInner = 80.0;
constexpr double kOuter = 100.0;
constexpr double kHeight = 6.0;
constexpr std::size_t kColumns = 72;

/// A tube on a firm core with a thread around its middle that stands for its whole height.
ElasticProblem Banded(const ElasticMaterial& material) {
  ElasticProblem problem = Tube(kColumns, 5, kInner, kOuter, kHeight, material);
  BandFibre fibre;
  fibre.plane << 1.0, 0.0, 0.0, 0.0, 1.0, 0.0;
  for (std::size_t i = 0; i < kColumns; ++i) {
    for (std::size_t j = 0; j < 2; ++j) {
      const std::size_t node = problem.grid.Node(i, j, 0);
      problem.held[3 * node] = problem.held[3 * node + 1] = 1;
    }
    const std::size_t skin = problem.grid.Node(i, 0, 4);
    fibre.points.push_back({i, 0.5, problem.grid.nodes[skin] + Vector3d(0.0, 0.0, 0.5 * kHeight)});
  }
  const double step = std::numbers::pi / static_cast<double>(kColumns);
  fibre.length_factor = step / std::sin(step);
  fibre.width = kHeight;
  problem.fibres.push_back(fibre);
  return problem;
}

TEST(BandFibre, HullPressesInwardsOnlyAndSpansHollows) {
  // A square with one side dented: the thread spans the dent.
  BandFibre fibre;
  fibre.plane << 1.0, 0.0, 0.0, 0.0, 1.0, 0.0;
  fibre.rest_length = 300.0;
  fibre.stiffness = 30.0;
  const std::vector<Vector3d> points{
      {50.0, -50.0, 1.0}, {30.0, 0.0, 2.0}, {50.0, 50.0, 3.0}, {-50.0, 50.0, 4.0}, {-50.0, -50.0, 5.0}};
  const FibreState state = Stretch(fibre, points);
  EXPECT_NEAR(state.length, 400.0, 1e-12);
  EXPECT_NEAR(state.tension, 30.0 * 100.0 / 300.0, 1e-12);
  EXPECT_NEAR(state.energy, 0.5 * 30.0 * 100.0 * 100.0 / 300.0, 1e-9);
  EXPECT_EQ(state.gradient[1], Vector3d::Zero());
  EXPECT_LE((state.gradient[0] - Vector3d(1.0, -1.0, 0.0)).norm(), 1e-12);
  fibre.rest_length = 500.0;
  EXPECT_EQ(Stretch(fibre, points).tension, 0.0);
}

TEST(BandFibre, SqueezesATubeOnACoreAsLameSays) {
  for (const double poisson : {0.3, 0.49}) {
    const ElasticMaterial material{0.02, poisson};
    ElasticProblem problem = Banded(material);
    problem.fibres[0].rest_length = 580.0;
    problem.fibres[0].stiffness = 1.5;
    ElasticOptions options;
    options.method = ElasticMethod::kLinear;
    const auto solution = SolveElastic(problem, options, {});
    ASSERT_TRUE(solution) << solution.error().Text();
    // Plane strain, u(a) = 0: u = A(r - a²/r), σ_r = A(2(λ + μ) + 2μ a²/r²) = -T/(R w) at R.
    const double by_pressure =
        (kOuter - kInner * kInner / kOuter) /
        (2.0 * (material.lambda() + material.mu()) + 2.0 * material.mu() * kInner * kInner / (kOuter * kOuter));
    // T = k (2π(R + u) - L0)/L0 and u = -by_pressure · T/(R w).
    const double give = by_pressure / (kOuter * kHeight);
    const double slope = problem.fibres[0].stiffness / problem.fibres[0].rest_length;
    const double tension = slope * (2.0 * std::numbers::pi * kOuter - problem.fibres[0].rest_length) /
                           (1.0 + slope * 2.0 * std::numbers::pi * give);
    EXPECT_NEAR(solution->fibres[0].tension / tension, 1.0, 0.01) << poisson;
    EXPECT_NEAR(RadialMovement(problem, *solution, problem.grid.Node(7, 0, 4)) / (-give * tension), 1.0, 0.01);
    std::vector<Vector3d> positions;
    for (const FibrePoint& point : problem.fibres[0].points) positions.push_back(point.rest);
    const ContactPressure contact = ContactOf(problem.fibres[0], solution->fibres[0], positions);
    EXPECT_NEAR(contact.largest / (tension / (kOuter * kHeight)), 1.0, 0.01);
    EXPECT_NEAR(contact.area / (2.0 * std::numbers::pi * kOuter * kHeight), 1.0, 0.01);
  }
}

TEST(BandFibre, ReachesTheGirthThatIsAskedFor) {
  ElasticProblem problem = Banded({0.02, 0.45});
  problem.fibres[0].target = 600.0;
  const auto solution = SolveElastic(problem, {}, {});
  ASSERT_TRUE(solution) << solution.error().Text();
  EXPECT_EQ(solution->termination, "converged");
  EXPECT_NEAR(solution->fibres[0].length, 600.0, 1e-3);
  for (std::size_t n = 1; n < solution->potential.size(); ++n) {
    EXPECT_LE(solution->potential[n], solution->potential[n - 1] * (1.0 + 1e-12));
  }
}

TEST(BandFibre, DoesNothingWhenItIsLong) {
  ElasticProblem problem = Banded({0.02, 0.45});
  problem.fibres[0].rest_length = 700.0;
  problem.fibres[0].stiffness = 10.0;
  const auto solution = SolveElastic(problem, {}, {});
  ASSERT_TRUE(solution) << solution.error().Text();
  EXPECT_EQ(solution->steps, 0);
  EXPECT_EQ(solution->fibres[0].tension, 0.0);
}

}  // namespace
}  // namespace annulus
