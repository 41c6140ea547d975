#include "fitting/fit_uncertainty.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>

#include "fitting/covariance.h"
#include "fitting/sample_screening.h"
#include "tests/fitting/synthetic_scan.h"

namespace annulus {
namespace {

/// A scan, its fit, and the same smoother as dense matrices.
struct Fitted {
  std::vector<SurfaceSample> samples;
  FitInput input;
  AdaptiveFit fit;

  Fitted(std::vector<SurfaceSample> scan, double noise)
      : samples(std::move(scan)),
        input{samples, std::vector<char>(samples.size(), 1),
              CellGrid(samples, SampleGrid(samples), std::vector(samples.size(), SampleVerdict::kGood)), noise} {
    auto result = FitAdaptive(input, {});
    if (!result) throw std::runtime_error(result.error().Text());
    fit = std::move(*result);
  }

  /// B with rows scaled to unit noise: the data matrix is BᵀB.
  [[nodiscard]] Eigen::MatrixXd Design() const {
    const std::vector<SampleRow>& rows = fit.system->rows();
    Eigen::MatrixXd b = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(rows.size()), fit.coefficients.size());
    for (std::size_t k = 0; k < rows.size(); ++k) {
      const SurfaceSample& s = samples[rows[k].sample];
      const double factor = fit.factors().empty() ? 1.0 : fit.factors()[k];
      const double scale = std::sqrt(static_cast<double>(rows[k].weight) * factor) / input.noise;
      for (const CoefficientWeight& w : fit.basis->ActiveRow(s.theta, s.z)) {
        b(static_cast<Eigen::Index>(k), static_cast<Eigen::Index>(w.index)) += scale * w.weight;
      }
    }
    return b;
  }
  [[nodiscard]] Eigen::MatrixXd Inverse() const {
    const Eigen::MatrixXd upper = fit.system->NormalMatrix(fit.weights, fit.factors());
    const Eigen::MatrixXd full = upper.selfadjointView<Eigen::Upper>();
    return full.llt().solve(Eigen::MatrixXd::Identity(full.rows(), full.cols()));
  }
};

test::ScanShape SmallShape(double noise) {
  test::ScanShape shape;
  shape.levels = 40;
  shape.sensors = 40;
  shape.noise = noise;
  shape.seed = 12;
  return shape;
}

/// S = Σ_k (I − H)^k H with H = B A⁻¹ Bᵀ, k = 0 … kTwicings, for rows of unit noise.
Eigen::MatrixXd Smoother(const Fitted& fitted) {
  const Eigen::MatrixXd b = fitted.Design();
  const Eigen::MatrixXd h = b * fitted.Inverse() * b.transpose();
  Eigen::MatrixXd s = h;
  for (int k = 0; k < kTwicings; ++k) s += h - h * s;
  return s;
}

TEST(FitUncertainty, CountsParametersAndNoiseLikeTheDenseSmoother) {
  const Fitted fitted(test::SyntheticScan(test::SmoothTrunk, SmallShape(0.5)), 0.5);
  const Eigen::MatrixXd s = Smoother(fitted);
  const FitUncertainty uncertainty = AssessUncertainty(fitted.input, fitted.fit);
  // Four probes of the trace have the sd sqrt(2 (trace SSᵀ − Σ S_ii²) / 4): here 4 %.
  EXPECT_NEAR(uncertainty.effective_parameters, s.trace(), 0.12 * s.trace());
  const Eigen::VectorXd residuals = fitted.fit.system->Residuals(fitted.fit.coefficients);
  const auto n = static_cast<double>(residuals.size());
  const double freedom = n - 2.0 * s.trace() + s.squaredNorm();
  EXPECT_NEAR(uncertainty.noise_sigma, std::sqrt(residuals.squaredNorm() / freedom), 0.01 * 0.5);
  EXPECT_NEAR(uncertainty.rms, std::sqrt(residuals.squaredNorm() / n), 1e-12);
}

TEST(FitUncertainty, ThePosteriorIsThatOfTheRepeatedSmoothing) {
  // Posterior variance of a fitted radius: σ² S_kk. One smoothing with a quarter of the penalty stands for four.
  const Fitted fitted(test::SyntheticScan(test::SmoothTrunk, SmallShape(0.5)), 0.5);
  const Eigen::MatrixXd s = Smoother(fitted);
  const auto covariance =
      SurfaceCovariance::FromNormalMatrix(PosteriorPrecision(fitted.fit, fitted.input.noise), *fitted.fit.basis);
  ASSERT_TRUE(covariance.has_value()) << covariance.error().Text();
  double mean = 0.0;
  for (Eigen::Index k = 0; k < s.rows(); ++k) {
    const SurfaceSample& sample = fitted.samples[fitted.fit.system->rows()[static_cast<std::size_t>(k)].sample];
    const double sigma = std::sqrt(covariance->LocalVariance(fitted.fit.basis->ActiveRow(sample.theta, sample.z)));
    const double ratio = sigma / (fitted.input.noise * std::sqrt(s(k, k)));
    EXPECT_NEAR(ratio, 1.0, 0.04) << k;
    mean += ratio / static_cast<double>(s.rows());
  }
  EXPECT_NEAR(mean, 1.0, 0.015);
}

TEST(FitUncertainty, ScalesWithTheNoiseThatWasFound) {
  const Fitted fitted(test::SyntheticScan(test::SmoothTrunk, SmallShape(0.5)), 0.5);
  const Eigen::SparseMatrix<double> one = PosteriorPrecision(fitted.fit, 0.5);
  const Eigen::SparseMatrix<double> two = PosteriorPrecision(fitted.fit, 1.0);
  EXPECT_LE((one - 4.0 * two).norm(), 1e-12 * one.norm());
}

TEST(FitUncertainty, FindsDetailThatTheSurfaceDoesNotFollow) {
  // Waves of 0.15 mm rms: random from sensor to sensor, 12 mm long upwards, four levels.
  constexpr double kDetail = 0.15;
  test::ScanShape shape;
  shape.levels = 120;
  shape.sensors = 90;
  shape.pitch = 3.0;
  shape.noise = 0.5;
  std::mt19937_64 random(8);
  std::vector<double> phases;
  for (std::uint16_t k = 0; k < shape.sensors; ++k) phases.push_back(test::Uniform(random, 0.0, kTwoPi));
  const auto rough = [&](double theta, double z) {
    const auto sensor = static_cast<std::size_t>(std::lround(theta / kTwoPi * 90.0)) % phases.size();
    return test::SmoothTrunk(theta, z) + kDetail * std::sqrt(2.0) * std::cos(kTwoPi * z / 24.0 + phases[sensor]);
  };
  const Fitted with(test::SyntheticScan(rough, shape), 0.5);
  const Fitted without(test::SyntheticScan(test::SmoothTrunk, shape), 0.5);
  EXPECT_NEAR(AssessUncertainty(with.input, with.fit).detail_sigma, kDetail, 0.3 * kDetail);
  EXPECT_LE(AssessUncertainty(without.input, without.fit).detail_sigma, 0.5 * kDetail);
}

TEST(FitUncertainty, IsFiniteWithoutNoise) {
  const Fitted fitted(test::SyntheticScan([](double, double) { return 120.0; }, SmallShape(0.0)), kSmallestNoise);
  const FitUncertainty uncertainty = AssessUncertainty(fitted.input, fitted.fit);
  EXPECT_LE(uncertainty.noise_sigma, 1e-6);
  EXPECT_LE(uncertainty.detail_sigma, 1e-6);
  const Eigen::SparseMatrix<double> precision = PosteriorPrecision(fitted.fit, uncertainty.noise_sigma);
  ASSERT_TRUE(SurfaceCovariance::FromNormalMatrix(precision, *fitted.fit.basis).has_value());
}

}  // namespace
}  // namespace annulus
