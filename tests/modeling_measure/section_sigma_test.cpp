#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <random>

#include "fitting/fit_surface.h"
#include "modeling/measure/section.h"
#include "modeling/measure/slab.h"
#include "tests/fitting/synthetic_scan.h"
#include "tests/modeling_measure/interpolated_body.h"

namespace annulus {
namespace {

/// A trunk with hollows whose normal matrix is that of 300 returns of sd 0.4 mm and a weak prior.
SurfaceModel UncertainBody() {
  SurfaceModel model =
      test::InterpolatedBody([](double theta, double z) { return 100.0 + 20.0 * std::cos(3.0 * theta) - 0.2 * z; }, 18,
                             {0.0, 20.0, 50.0, 70.0, 100.0});
  const SplineSurface& surface = model.main().surface;
  const Eigen::Index n = surface.coefficients().size();
  Eigen::MatrixXd normal = Eigen::MatrixXd::Identity(n, n) / (2.0 * 2.0);
  std::mt19937_64 random(21);
  for (int k = 0; k < 300; ++k) {
    const RadiusRow row = surface.Row(test::Uniform(random, 0.0, kTwoPi), test::Uniform(random, 0.0, 100.0));
    for (std::size_t a = 0; a < 16; ++a) {
      for (std::size_t b = 0; b < 16; ++b) {
        normal(static_cast<Eigen::Index>(row.index[a]), static_cast<Eigen::Index>(row.index[b])) +=
            row.value[a] * row.value[b] / (0.4 * 0.4);
      }
    }
  }
  const Eigen::MatrixXd upper = normal.triangularView<Eigen::Upper>();
  model.segments.front().normal_matrix = upper.sparseView();
  return model;
}

/// What is measured, as plain numbers.
struct Numbers {
  enum { kPerimeter, kTape, kArea, kVolume, kSkin, kMeridian, kMeridianTape, kCount };
  std::array<Uncertain, kCount> all;
};

Numbers Measure(const SurfaceModel& model) {
  const auto body = MeasuredSurface::FromModel(model);
  const auto section = MeasureSection(*body, 40.0);
  const auto slab = MeasureSlab(*body, 15.0, 80.0);
  const auto meridian = MeridianLength(*body, 1.0, 10.0, 90.0);
  const auto meridian_tape = MeridianTape(*body, 1.0, 10.0, 90.0);
  if (!section || !slab || !meridian || !meridian_tape) throw std::runtime_error("the body cannot be measured");
  return {{section->perimeter, section->tape, section->area, slab->volume, slab->area, body->WithSigma(*meridian),
           body->WithSigma(*meridian_tape)}};
}

TEST(Sigma, IsTheScatterOverSurfacesDrawnFromTheCovariance) {
  // c = c₀ + L⁻ᵀ ξ with A = L Lᵀ and ξ standard normal has the covariance A⁻¹.
  const SurfaceModel model = UncertainBody();
  const Numbers expected = Measure(model);
  const Eigen::MatrixXd normal = Eigen::MatrixXd(model.main().normal_matrix).selfadjointView<Eigen::Upper>();
  const Eigen::LLT<Eigen::MatrixXd> factor(normal);
  std::mt19937_64 random(22);
  constexpr int kDraws = 400;
  std::array<double, Numbers::kCount> sums{};
  std::array<double, Numbers::kCount> squares{};
  for (int draw = 0; draw < kDraws; ++draw) {
    const SplineSurface& surface = model.main().surface;
    Eigen::VectorXd noise(surface.coefficients().size());
    for (double& value : noise) value = test::Normal(random);
    const Eigen::VectorXd shift = factor.matrixU().solve(noise);
    SurfaceModel drawn;
    drawn.segments.push_back({"body",
                              {surface.theta_basis(), surface.z_basis(), surface.coefficients() + shift},
                              model.main().knowledge,
                              {},
                              {},
                              {}});
    const Numbers numbers = Measure(drawn);
    for (std::size_t k = 0; k < Numbers::kCount; ++k) {
      const double deviation = numbers.all[k].value - expected.all[k].value;
      sums[k] += deviation;
      squares[k] += deviation * deviation;
    }
  }
  for (std::size_t k = 0; k < Numbers::kMeridian; ++k) {
    const double mean = sums[k] / kDraws;
    const double sd = std::sqrt(squares[k] / kDraws - mean * mean);
    EXPECT_NEAR(expected.all[k].sigma, sd, 0.15 * sd) << "quantity " << k;
  }
}

TEST(Sigma, OfARadiusFollowsFromIndependentCoefficients) {
  // Independent coefficients of sd s: the sd of the radius is s·sqrt(Σ N²N²), at a knot in both directions
  // s·(1/36 + 16/36 + 1/36) = s/2. The matrix has a zero wherever two coefficients act at one place.
  SurfaceModel model = test::InterpolatedBody([](double, double) { return 90.0; }, 12, UniformBreakpoints(0, 100, 10));
  SurfaceSegment& segment = model.segments.front();
  const Eigen::Index n = segment.surface.coefficients().size();
  std::vector<Eigen::Triplet<double>> entries;
  for (int k = 0; k < n; ++k) entries.emplace_back(k, k, 1.0 / (0.3 * 0.3));
  for (double z = 1.0; z < 100.0; z += 2.0) {
    for (double theta = 0.01; theta < kTwoPi; theta += 0.1) {
      const RadiusRow row = segment.surface.Row(theta, z);
      for (const std::size_t a : row.index) {
        for (const std::size_t b : row.index) {
          if (a < b) entries.emplace_back(static_cast<int>(a), static_cast<int>(b), 0.0);
        }
      }
    }
  }
  segment.normal_matrix.resize(n, n);
  segment.normal_matrix.setFromTriplets(entries.begin(), entries.end());
  const auto body = MeasuredSurface::FromModel(model);
  ASSERT_TRUE(body.has_value());
  EXPECT_NEAR(body->RadiusSigma(0.0, 50.0), 0.3 * 0.5, 1e-12);
}

TEST(Sigma, OfARadiusHoldsTheDetail) {
  SurfaceModel model = UncertainBody();
  const auto smooth = MeasuredSurface::FromModel(model);
  ASSERT_TRUE(smooth.has_value());
  SurfaceModel rough = model;
  rough.segments.front().detail_sigma = 0.3;
  const auto body = MeasuredSurface::FromModel(rough);
  ASSERT_TRUE(body.has_value());
  for (const double theta : {0.0, 1.3, 4.0}) {
    EXPECT_NEAR(body->RadiusSigma(theta, 40.0), std::hypot(smooth->RadiusSigma(theta, 40.0), 0.3), 1e-12);
  }
}

TEST(Sigma, OfMeasuresTakesDetailAsIndependentErrorsOfTheCoefficients) {
  // Coefficients of sd d on a uniform grid give a radius the mean variance d² (∫N²)², ∫N² = 151/315 for cubic B-splines
  // (scipy.interpolate.BSpline.basis_element(range(5)), squared, integrated over 0 … 4).
  SurfaceModel model = test::InterpolatedBody([](double, double) { return 90.0; }, 12, UniformBreakpoints(0, 100, 10));
  SurfaceSegment& segment = model.segments.front();
  const Eigen::Index n = segment.surface.coefficients().size();
  segment.normal_matrix.resize(n, n);
  segment.normal_matrix.setIdentity();
  segment.normal_matrix *= 1e12;  // nothing else is uncertain
  segment.detail_sigma = 0.3;
  const auto body = MeasuredSurface::FromModel(model);
  ASSERT_TRUE(body.has_value());
  std::mt19937_64 random(31);
  double variance = 0.0;
  constexpr int kPlaces = 4000;
  for (int k = 0; k < kPlaces; ++k) {
    const RadiusRow row = segment.surface.Row(test::Uniform(random, 0.0, kTwoPi),
                                              test::Uniform(random, 30.0, 70.0));  // away from the ends
    GradientSum gradient(segment.surface);
    gradient.AddRow(row, 1.0, 0.0, 0.0);
    variance += std::pow(body->WithSigma({90.0, gradient.Get()}).sigma, 2) / kPlaces;
  }
  EXPECT_NEAR(std::sqrt(variance), 0.3, 0.003);
}

TEST(Sigma, OfFittedGirthsCoversTheTruth) {
  // Deviation over sigma of girths on smooth trunks, many seeds: root mean square 1 if sigma were exact. Smoothing
  // leaves some bias on top, and the truth is smoother than the prior: hence the bounds.
  test::ScanShape shape;
  shape.levels = 40;
  shape.sensors = 60;
  shape.noise = 0.5;
  double squares = 0.0;
  int count = 0;
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    shape.seed = seed;
    const auto fit = FitSurface(test::SyntheticScan(test::SmoothTrunk, shape), {}, {});
    ASSERT_TRUE(fit.has_value());
    const auto body = MeasuredSurface::FromModel(fit->model);
    ASSERT_TRUE(body.has_value()) << body.error().Text();
    for (const double z : {42.0, 101.0, 160.0}) {
      double area = 0.0;
      for (int k = 0; k < 3600; ++k) area += std::pow(test::SmoothTrunk(kTwoPi * k / 3600.0, z), 2) * kPi / 3600.0;
      const auto section = MeasureSection(*body, z);
      ASSERT_TRUE(section.has_value());
      EXPECT_GT(section->tape.sigma, 0.0);
      EXPECT_LT(section->tape.sigma, 2.0);
      squares += std::pow((section->area.value - area) / section->area.sigma, 2);
      ++count;
    }
  }
  EXPECT_GE(std::sqrt(squares / count), 0.4);
  EXPECT_LE(std::sqrt(squares / count), 1.6);
}

}  // namespace
}  // namespace annulus
