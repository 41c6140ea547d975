#include "fitting/uniform_fit.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <set>

#include "fitting/banded_cholesky.h"
#include "fitting/front_kernels.h"
#include "tests/fitting/synthetic_scan.h"

namespace annulus {
namespace {

using test::Normal;
using test::ScanShape;
using test::SmoothTrunk;
using test::SyntheticScan;
using test::Uniform;

/// A positive definite matrix that is a sum of one form per knot cell, and the same made densely.
struct RandomMatrix {
  TensorMatrix tensor;
  Eigen::MatrixXd dense;
};

RandomMatrix MakeMatrix(std::size_t around, std::size_t up) {
  RandomMatrix made{TensorMatrix(around, up), Eigen::MatrixXd()};
  const auto n = static_cast<Eigen::Index>(around * up);
  made.dense = 0.01 * Eigen::MatrixXd::Identity(n, n);
  made.tensor.AddToDiagonal(0.01);
  std::mt19937_64 random(around * 100 + up);
  for (std::size_t j = 0; j + 3 < up; ++j) {
    for (std::size_t i = 0; i < around; ++i) {
      TensorForm form{};
      for (int k = 0; k < 3; ++k) {
        TensorRow row;
        for (double& v : row.theta) v = Uniform(random, -1.0, 1.0);
        for (double& v : row.z) v = Uniform(random, -1.0, 1.0);
        row.weight = Uniform(random, 0.1, 1.0);
        AddTensorRows({&row, 1}, form);
        Eigen::VectorXd gradient = Eigen::VectorXd::Zero(n);
        for (std::size_t b = 0; b < 4; ++b) {
          for (std::size_t a = 0; a < 4; ++a) {
            gradient[static_cast<Eigen::Index>((j + b) * around + (i + around - 1 + a) % around)] +=
                row.z[b] * row.theta[a];
          }
        }
        made.dense += row.weight * gradient * gradient.transpose();
      }
      made.tensor.AddForm(i, j, form);
    }
  }
  return made;
}

Eigen::VectorXd RandomVector(Eigen::Index size, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  Eigen::VectorXd v(size);
  for (double& x : v) x = Uniform(random, -1.0, 1.0);
  return v;
}

TEST(TensorMatrix, IsTheSumOfItsForms) {
  const RandomMatrix made = MakeMatrix(9, 7);
  const Eigen::MatrixXd upper = made.tensor.UpperTriangle();
  EXPECT_LE((upper - Eigen::MatrixXd(made.dense.triangularView<Eigen::Upper>())).cwiseAbs().maxCoeff(), 1e-13);
  const Eigen::VectorXd x = RandomVector(made.dense.rows(), 1);
  EXPECT_LE((made.tensor * x - made.dense * x).cwiseAbs().maxCoeff(), 1e-13);
  EXPECT_NEAR(made.tensor.MeanDiagonal(), made.dense.diagonal().mean(), 1e-14);
}

TEST(TensorMatrix, AddsKroneckerProducts) {
  // Symmetric bands of half width 3, the one around cyclic.
  constexpr Eigen::Index kAround = 10;
  constexpr Eigen::Index kUp = 6;
  Eigen::MatrixXd around = Eigen::MatrixXd::Zero(kAround, kAround);
  Eigen::MatrixXd up = Eigen::MatrixXd::Zero(kUp, kUp);
  for (Eigen::Index d = 0; d <= 3; ++d) {
    for (Eigen::Index i = 0; i < kAround; ++i) {
      around(i, (i + d) % kAround) = around((i + d) % kAround, i) = std::cos(static_cast<double>(3 * i + d));
    }
    for (Eigen::Index i = 0; i + d < kUp; ++i) up(i, i + d) = up(i + d, i) = std::sin(static_cast<double>(2 * i + d));
  }
  TensorMatrix tensor(kAround, kUp);
  tensor.AddProduct(0.5, up, around);
  const Eigen::MatrixXd upper = tensor.UpperTriangle();
  for (Eigen::Index j = 0; j < kUp; ++j) {
    for (Eigen::Index k = j; k < kUp; ++k) {
      Eigen::MatrixXd expected = 0.5 * up(j, k) * around;
      if (j == k) expected = Eigen::MatrixXd(expected.triangularView<Eigen::Upper>());
      EXPECT_LE((upper.block(j * kAround, k * kAround, kAround, kAround) - expected).cwiseAbs().maxCoeff(), 1e-15);
    }
  }
}

TEST(BandedCholesky, SolvesAsDenseCholeskyDoes) {
  for (const auto& [around, up] : {std::pair<std::size_t, std::size_t>{8, 4}, {9, 7}, {13, 5}, {48, 9}}) {
    const RandomMatrix made = MakeMatrix(around, up);
    const Eigen::VectorXd b = RandomVector(made.dense.rows(), 2);
    const auto factor = BandedCholesky::Factor(made.tensor);
    ASSERT_TRUE(factor.has_value());
    const Eigen::VectorXd expected = made.dense.llt().solve(b);
    EXPECT_LE((factor->Solve(b) - expected).cwiseAbs().maxCoeff(), 1e-11 * expected.cwiseAbs().maxCoeff())
        << around << " by " << up;
  }
}

TEST(BandedCholesky, RefusesAMatrixThatIsNotPositiveDefinite) {
  RandomMatrix made = MakeMatrix(9, 7);
  made.tensor.AddToDiagonal(-1.0);
  EXPECT_FALSE(BandedCholesky::Factor(made.tensor).has_value());
}

/// Forms of clamped splines over `intervals`, at `places` regular places.
AxisForms ClampedForms(std::size_t intervals, std::size_t places) {
  const ClampedCubicBasis basis(UniformBreakpoints(0.0, 1.0, intervals));
  const auto n = static_cast<Eigen::Index>(basis.count());
  Eigen::MatrixXd values = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(places), n);
  Eigen::MatrixXd bends = values;
  for (std::size_t p = 0; p < places; ++p) {
    const CubicBasis at = basis.At(static_cast<double>(p) / static_cast<double>(places - 1));
    for (std::size_t k = 0; k < 4; ++k) {
      values(static_cast<Eigen::Index>(p), static_cast<Eigen::Index>(at.index[k])) = at.value[k];
      bends(static_cast<Eigen::Index>(p), static_cast<Eigen::Index>(at.index[k])) = at.second[k];
    }
  }
  return {values.transpose() * values, bends.transpose() * bends};
}

/// Forms of periodic splines and the splines' values at `places` regular places.
struct RingForms {
  AxisForms forms;
  Eigen::MatrixXd values;
};
RingForms PeriodicForms(std::size_t count, std::size_t places) {
  const PeriodicCubicBasis basis(count);
  Eigen::MatrixXd values = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(places), static_cast<Eigen::Index>(count));
  Eigen::MatrixXd bends = values;
  for (std::size_t p = 0; p < places; ++p) {
    const CubicBasis at = basis.At(kTwoPi * static_cast<double>(p) / static_cast<double>(places));
    for (std::size_t k = 0; k < 4; ++k) {
      values(static_cast<Eigen::Index>(p), static_cast<Eigen::Index>(at.index[k])) = at.value[k];
      bends(static_cast<Eigen::Index>(p), static_cast<Eigen::Index>(at.index[k])) = at.second[k];
    }
  }
  return {{values.transpose() * values, bends.transpose() * bends}, values};
}

TEST(AxisModes, MakeBothFormsDiagonalFromEitherEnd) {
  for (const std::size_t intervals : {9U, 10U}) {
    const AxisForms forms = ClampedForms(intervals, 31);
    for (const AxisModes& modes : {FindModes(forms), FindMirroredModes(forms)}) {
      const Eigen::MatrixXd& u = modes.shapes;
      const Eigen::Index n = u.rows();
      EXPECT_LE((u.transpose() * forms.gram * u - Eigen::MatrixXd::Identity(n, n)).cwiseAbs().maxCoeff(), 1e-10);
      const Eigen::MatrixXd bends = u.transpose() * forms.bend * u;
      EXPECT_LE((bends - Eigen::MatrixXd(modes.bends.asDiagonal())).cwiseAbs().maxCoeff(), 1e-8 * bends.maxCoeff());
      EXPECT_EQ((modes.bends.array() == 0.0).count(), 2);  // constant and linear
    }
  }
}

/// A noisy wave on a complete grid and all that the dense formulas need.
struct DenseSmoothing {
  static constexpr std::size_t kColumns = 30;
  static constexpr std::size_t kRows = 25;
  RingForms ring = PeriodicForms(10, kColumns);
  AxisForms height = ClampedForms(9, kRows);
  Eigen::MatrixXd gram;
  Eigen::MatrixXd bend_theta;
  Eigen::MatrixXd bend_z;
  GridData data;
  Eigen::VectorXd right;

  DenseSmoothing() {
    const ClampedCubicBasis basis(UniformBreakpoints(0.0, 1.0, 9));
    Eigen::MatrixXd across = Eigen::MatrixXd::Zero(kRows, static_cast<Eigen::Index>(basis.count()));
    Eigen::MatrixXd y(kColumns, kRows);
    std::mt19937_64 random(3);
    for (Eigen::Index row = 0; row < y.cols(); ++row) {
      const double z = static_cast<double>(row) / (kRows - 1.0);
      const CubicBasis at = basis.At(z);
      for (std::size_t k = 0; k < 4; ++k) across(row, static_cast<Eigen::Index>(at.index[k])) = at.value[k];
      for (Eigen::Index column = 0; column < y.rows(); ++column) {
        const double theta = kTwoPi * static_cast<double>(column) / kColumns;
        y(column, row) = 3.0 * std::sin(theta + 2.0 * z) + z * z + 0.4 * Normal(random);
      }
    }
    gram = Kronecker(height.gram, ring.forms.gram);
    bend_theta = Kronecker(height.gram, ring.forms.bend);
    bend_z = Kronecker(height.bend, ring.forms.gram);
    data.projected = ring.values.transpose() * y * across;
    data.squares = y.squaredNorm();
    data.cells = static_cast<double>(y.size());
    right = Eigen::Map<const Eigen::VectorXd>(data.projected.data(), data.projected.size());
  }

  static Eigen::MatrixXd Kronecker(const Eigen::MatrixXd& outer, const Eigen::MatrixXd& inner) {
    Eigen::MatrixXd product(outer.rows() * inner.rows(), outer.cols() * inner.cols());
    for (Eigen::Index j = 0; j < outer.cols(); ++j) {
      for (Eigen::Index i = 0; i < outer.rows(); ++i) {
        product.block(i * inner.rows(), j * inner.cols(), inner.rows(), inner.cols()) = outer(i, j) * inner;
      }
    }
    return product;
  }

  [[nodiscard]] SmoothingWeights Choose() const {
    return ChooseSeparableSmoothing(FindModes(ring.forms), FindMirroredModes(height), data);
  }

  /// Solution, hat matrix in the coefficients' coordinates, and residual sum of squares for given weights.
  struct Solution {
    Eigen::MatrixXd hat;
    double squares = 0.0;
  };
  [[nodiscard]] Solution Solve(double theta, double z) const {
    const Eigen::LLT<Eigen::MatrixXd> llt(gram + theta * bend_theta + z * bend_z);
    const Eigen::VectorXd c = llt.solve(right);
    return {llt.solve(gram), data.squares - 2.0 * c.dot(right) + c.dot(gram * c)};
  }
  [[nodiscard]] double Score(double theta, double z) const {
    const Solution solution = Solve(theta, z);
    return solution.squares / std::pow(data.cells - solution.hat.trace(), 2);
  }
};

TEST(SeparableSmoothing, CountsParametersAsTheDenseHatMatrixDoes) {
  const DenseSmoothing dense;
  const SmoothingWeights weights = dense.Choose();
  const DenseSmoothing::Solution solution = dense.Solve(weights.theta, weights.z);
  const double trace = solution.hat.trace();
  const double residual = 2.0 * trace - (solution.hat * solution.hat).trace();
  EXPECT_NEAR(weights.effective_parameters, trace, 1e-6 * trace);
  EXPECT_NEAR(weights.residual_parameters, residual, 1e-6 * residual);
  EXPECT_NEAR(weights.residual_sd, std::sqrt(solution.squares / (dense.data.cells - residual)), 1e-8);
  EXPECT_NEAR(weights.residual_sd, 0.4, 0.04);
}

TEST(SeparableSmoothing, FindsTheLeastCrossValidationScore) {
  const DenseSmoothing dense;
  const SmoothingWeights weights = dense.Choose();
  const double best = dense.Score(weights.theta, weights.z);
  for (const double theta : {0.8, 1.0, 1.25}) {
    for (const double z : {0.8, 1.0, 1.25}) {
      if (theta == 1.0 && z == 1.0) continue;
      EXPECT_GT(dense.Score(theta * weights.theta, z * weights.z), best) << theta << ' ' << z;
    }
  }
}

TEST(UniformTensorBasis, AgreesWithTheSurface) {
  const UniformTensorBasis basis(11, 50.0, 250.0, 17);
  const SplineSurface surface(basis.theta(), basis.z(), RandomVector(11 * 20, 4));
  std::mt19937_64 random(5);
  for (int k = 0; k < 2000; ++k) {
    const double theta = Uniform(random, 0.0, kTwoPi);
    const double z = k < 18 ? basis.z().breakpoints()[static_cast<std::size_t>(k)] : Uniform(random, 50.0, 250.0);
    const TensorPlace place = basis.At(theta, z);
    EXPECT_NEAR(basis.Value(place, surface.coefficients()), surface.Radius(theta, z), 1e-13);
    Eigen::VectorXd gradient = Eigen::VectorXd::Zero(11 * 20);
    basis.AddTransposed(place, 2.0, gradient);
    EXPECT_NEAR(gradient.dot(surface.coefficients()), 2.0 * surface.Radius(theta, z), 1e-13);
  }
}

/// A scan, screened; what FitUniform takes.
class Scanned {
 public:
  explicit Scanned(std::vector<SurfaceSample> samples)
      : samples_(std::move(samples)),
        grid_(samples_),
        screening_(ScreenSamples(samples_, grid_, {})),
        cells_(samples_, grid_, screening_.verdicts),
        noise_(std::max(1e-3, EstimateNoise(samples_, grid_, screening_.verdicts))) {}

  [[nodiscard]] UniformInput input() const { return {samples_, screening_.verdicts, cells_, noise_}; }
  [[nodiscard]] const std::vector<SurfaceSample>& samples() const { return samples_; }

 private:
  std::vector<SurfaceSample> samples_;
  SampleGrid grid_;
  Screening screening_;
  CellGrid cells_;
  double noise_;
};

/// 40 levels of 60 sensors with 0.4 mm of noise, a hole, and 12 returns that the screening must let pass (4 mm off).
std::vector<SurfaceSample> SmallScan() {
  ScanShape shape;
  shape.levels = 40;
  shape.sensors = 60;
  shape.noise = 0.4;
  std::vector<SurfaceSample> samples = SyntheticScan(SmoothTrunk, shape);
  for (std::size_t k = 100; k < samples.size(); k += 199) samples[k].radius += k % 2 == 0 ? 4.0 : -4.0;
  std::erase_if(samples,
                [](const SurfaceSample& s) { return s.sensor > 20 && s.sensor < 34 && s.level > 10 && s.level < 22; });
  return samples;
}

constexpr std::size_t kAround = 16;
constexpr std::size_t kIntervals = 21;

/// The robust cost written out, with basis functions from the surface itself.
double CostOf(const UniformInput& input, const UniformFit& fit, const Eigen::VectorXd& coefficients) {
  const UniformProblem problem(input, kAround, kIntervals);
  const SplineSurface surface(problem.basis().theta(), problem.basis().z(), coefficients);
  double cost = 0.0;
  for (std::size_t k = 0; k < input.samples.size(); ++k) {
    if (input.verdicts[k] != SampleVerdict::kGood) continue;
    const SurfaceSample& s = input.samples[k];
    const double residual = std::abs(s.radius - surface.Radius(s.theta, s.z));
    const auto limit = std::find_if(fit.limits.begin(), fit.limits.end(), [&](auto& l) { return l.sample == k; });
    const bool linear = limit != fit.limits.end() && residual > limit->limit_mm;
    const double loss = linear ? limit->limit_mm * (2.0 * residual - limit->limit_mm) : residual * residual;
    cost += 0.5 * static_cast<double>(s.weight) * loss / (input.noise_sigma * input.noise_sigma);
  }
  const Eigen::VectorXd c = coefficients.array() - problem.mean_radius();
  problem.ForPenaltyRows(fit.smoothing, [&](const TensorPlace& row, double weight) {
    cost += 0.5 * weight * std::pow(problem.basis().Value(row, c), 2);
  });
  return cost;
}

TEST(FitUniform, LowersTheRobustCostToWhereItsNumericGradientIsZero) {
  const Scanned scan(SmallScan());
  const auto fit = FitUniform(scan.input(), kAround, kIntervals);
  ASSERT_TRUE(fit.has_value()) << fit.error().Text();
  EXPECT_GT(fit->iterations, 0);
  EXPECT_LT(fit->cost_end, fit->cost_start);
  const Eigen::VectorXd& c = fit->surface.coefficients();
  const double cost = CostOf(scan.input(), *fit, c);
  EXPECT_NEAR(fit->cost_end, cost, 1e-6 * cost);  // the small diagonal is not in the formula
  for (std::uint64_t seed = 0; seed < 8; ++seed) {
    const Eigen::VectorXd step = 1e-3 * RandomVector(c.size(), seed);
    const double up = CostOf(scan.input(), *fit, c + step);
    const double down = CostOf(scan.input(), *fit, c - step);
    const double curvature = up - 2.0 * cost + down;
    EXPECT_GT(curvature, 0.0);
    EXPECT_LE(std::abs(up - down), 0.02 * curvature) << "seed " << seed;  // the minimum lies within 1e-5 mm
    // Half the curvature is what the reported equations say.
    const Eigen::MatrixXd upper = fit->equations.UpperTriangle();
    EXPECT_NEAR(step.dot(upper.selfadjointView<Eigen::Upper>() * step), curvature, 0.03 * curvature);
  }
}

TEST(FitUniform, FindsWhatCeresFinds) {
  const Scanned scan(SmallScan());
  const auto fit = FitUniform(scan.input(), kAround, kIntervals);
  ASSERT_TRUE(fit.has_value());
  const UniformProblem problem(scan.input(), kAround, kIntervals);
  const Eigen::VectorXd zero = Eigen::VectorXd::Zero(fit->surface.coefficients().size());
  for (const auto solver : {CeresLinearSolver::kConjugateGradients, CeresLinearSolver::kSparseCholesky}) {
    for (const std::size_t width : {std::size_t{4}, kAround}) {
      const auto peer = SolveUniformWithCeres(problem, *fit, zero, {width, solver});
      ASSERT_TRUE(peer.has_value()) << peer.error().Text();
      EXPECT_EQ(peer->termination, "converged");
      EXPECT_NEAR(peer->cost, fit->cost_end, 1e-6 * fit->cost_end);
      for (const SurfaceSample& s : scan.samples()) {
        EXPECT_NEAR(peer->surface.Radius(s.theta, s.z), fit->surface.Radius(s.theta, s.z), 1e-3);
      }
    }
  }
  EXPECT_FALSE(SolveUniformWithCeres(problem, *fit, zero, {5, CeresLinearSolver::kSparseCholesky}).has_value());
}

TEST(FitUniform, IsMovedLittleByReturnsThatScreeningLetPass) {
  ScanShape shape;
  shape.noise = 0.2;
  std::vector<SurfaceSample> samples = SyntheticScan(SmoothTrunk, shape);
  const Scanned clean(samples);
  for (std::size_t k = 100; k < samples.size(); k += 331) samples[k].radius += 4.5;
  const Scanned spoiled(samples);
  const auto expected = FitUniform(clean.input(), 24, 40);
  const auto fit = FitUniform(spoiled.input(), 24, 40);
  ASSERT_TRUE(expected.has_value() && fit.has_value());
  double largest = 0.0;
  for (const SurfaceSample& s : samples) {
    largest = std::max(largest, std::abs(fit->surface.Radius(s.theta, s.z) - expected->surface.Radius(s.theta, s.z)));
  }
  EXPECT_LE(largest, 0.35);  // least squares: 4.5 mm times a leverage of 0.2 and more
}

TEST(FitUniform, LeavesResidualsOfTheSizeOfTheNoise) {
  ScanShape shape;
  shape.noise = 0.5;
  double chi_square = 0.0;
  constexpr int kSeeds = 10;
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    shape.seed = seed;
    const Scanned scan(SyntheticScan(SmoothTrunk, shape));
    const auto fit = FitUniform(scan.input(), 48, 48);
    ASSERT_TRUE(fit.has_value());
    const double ratio = std::pow(fit->noise_sigma_mm / 0.5, 2);
    EXPECT_GE(ratio, 0.9) << "seed " << seed;
    EXPECT_LE(ratio, 1.1) << "seed " << seed;
    chi_square += ratio / kSeeds;
  }
  EXPECT_NEAR(chi_square, 1.0, 0.02);
}

TEST(FitUniform, SmoothsEachWayAsThatWayNeeds) {
  // Many waves around, almost none up: strong smoothing belongs up only.
  ScanShape shape;
  shape.noise = 0.3;
  const auto fluted = [](double theta, double z) { return 150.0 + 3.0 * std::cos(11.0 * theta) + 0.02 * z; };
  const Scanned scan(SyntheticScan(fluted, shape));
  const auto fit = FitUniform(scan.input(), 48, 48);
  ASSERT_TRUE(fit.has_value());
  EXPECT_GT(fit->smoothing.z, 1e3 * fit->smoothing.theta);
  double squares = 0.0;
  for (const SurfaceSample& s : scan.samples()) {
    squares += std::pow(fit->surface.Radius(s.theta, s.z) - fluted(s.theta, s.z), 2);
  }
  EXPECT_LE(std::sqrt(squares / static_cast<double>(scan.samples().size())), 0.06);
}

/// Fits what is left of a trunk after `spoil` and expects the truth where samples are, within `rms` mm, and nothing
/// wild anywhere.
void ExpectSane(const std::function<void(std::vector<SurfaceSample>&)>& spoil, double rms) {
  ScanShape shape;
  shape.sensors = 180;
  shape.noise = 0.3;
  std::vector<SurfaceSample> samples = SyntheticScan(SmoothTrunk, shape);
  spoil(samples);
  const Scanned scan(samples);
  const auto fit = FitUniform(scan.input(), 48, 48);
  ASSERT_TRUE(fit.has_value()) << fit.error().Text();
  double squares = 0.0;
  double count = 0.0;
  for (std::size_t k = 0; k < samples.size(); ++k) {
    if (scan.input().verdicts[k] != SampleVerdict::kGood) continue;
    squares +=
        std::pow(fit->surface.Radius(samples[k].theta, samples[k].z) - SmoothTrunk(samples[k].theta, samples[k].z), 2);
    count += 1.0;
  }
  EXPECT_LE(std::sqrt(squares / count), rms);
  for (double z = 0.0; z <= shape.z_max(); z += 4.1) {
    for (double theta = 0.0; theta < kTwoPi; theta += 0.05) {
      EXPECT_NEAR(fit->surface.Radius(theta, z), SmoothTrunk(theta, z), 12.0) << theta << ' ' << z;
    }
  }
}

TEST(FitUniform, StaysSaneWithOutliersDeadSensorsAndMissingLevels) {
  ExpectSane(
      [](auto& samples) {
        std::mt19937_64 random(6);
        for (SurfaceSample& s : samples) {
          if (random() % 20 == 0) s.radius += Uniform(random, -200.0, 200.0);
        }
      },
      0.2);
  ExpectSane([](auto& samples) { std::erase_if(samples, [](auto& s) { return s.sensor == 17; }); }, 0.15);
  ExpectSane([](auto& samples) { std::erase_if(samples, [](auto& s) { return s.sensor >= 30 && s.sensor < 45; }); },
             0.15);
  ExpectSane([](auto& samples) { std::erase_if(samples, [](auto& s) { return s.level >= 25 && s.level < 35; }); },
             0.15);
  ExpectSane(
      [](auto& samples) {
        for (std::size_t k = 7; k < samples.size(); k += 50) {
          samples[k].radius = k % 3 == 0 ? std::numeric_limits<double>::quiet_NaN() : 1e308;
        }
      },
      0.15);
}

TEST(FitUniform, TakesEqualRangesEverywhere) {
  const Scanned scan(SyntheticScan([](double, double) { return 100.0; }, {}));
  const auto fit = FitUniform(scan.input(), 48, 48);
  ASSERT_TRUE(fit.has_value());
  EXPECT_NEAR(fit->surface.Radius(1.0, 50.0), 100.0, 1e-9);
  EXPECT_TRUE(std::isfinite(fit->noise_sigma_mm));
}

TEST(FitUniform, RefusesMoreKnotsThanMemoryHolds) {
  const Scanned scan(SyntheticScan(SmoothTrunk, {}));
  const auto fit = FitUniform(scan.input(), 720, 2000);
  ASSERT_FALSE(fit.has_value());
  EXPECT_THAT(fit.error().Text(), testing::HasSubstr("2 GB"));
}

TEST(FitUniform, RefusesMoreKnotsThanTheScanHasCells) {
  const Scanned scan(SyntheticScan(SmoothTrunk, {}));
  EXPECT_FALSE(FitUniform(scan.input(), 90, 20).has_value());
  EXPECT_FALSE(FitUniform(scan.input(), 20, 57).has_value());
  EXPECT_TRUE(FitUniform(scan.input(), 20, 1).has_value());
}

}  // namespace
}  // namespace annulus
