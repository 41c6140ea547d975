#include "modeling/measure/measured_surface.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <mutex>
#include <utility>

#include "fitting/paper_model.h"

namespace annulus {
namespace {

/// Mean of Σ (N_i N_j)² over the plane for uniform cubic B-splines: (∫N²)², ∫N² = 151/315.
constexpr double kSquaresOfSplines = (151.0 / 315.0) * (151.0 / 315.0);

constexpr std::size_t kDeviations = 8;
constexpr std::uint64_t kDeviationSeed = 20'000'102;

/// Signs, the same on every machine (SplitMix64: Steele, Lea, Flood 2014).
class Signs {
 public:
  explicit Signs(std::uint64_t seed) : state_(seed) {}

  Eigen::VectorXd Next(Eigen::Index count) {
    Eigen::VectorXd signs(count);
    for (double& sign : signs) {
      state_ += 0x9E3779B97F4A7C15ULL;
      std::uint64_t x = state_;
      x = (x ^ (x >> 30U)) * 0xBF58476D1CE4E5B9ULL;
      x = (x ^ (x >> 27U)) * 0x94D049BB133111EBULL;
      sign = ((x ^ (x >> 31U)) & 1U) != 0U ? 1.0 : -1.0;
    }
    return signs;
  }

 private:
  std::uint64_t state_;
};

/// By z-spline: how much of a deviation counts, 0 … 1. What the returns leave open, and detail that the surface does
/// not follow, have a size on the skin; fit and detail are uniform over the angles. Where the body is thinner than it
/// is on average (neck, crown), directions lie closer together, and neighbours have more in common by that.
std::vector<double> ShareByHeight(const SplineSurface& surface) {
  const auto width = static_cast<Eigen::Index>(surface.theta_basis().count());
  const auto rows = static_cast<Eigen::Index>(surface.z_basis().count());
  const Eigen::VectorXd radii =
      Eigen::Map<const Eigen::MatrixXd>(surface.coefficients().data(), width, rows).colwise().mean();
  const double mean = radii.mean();
  std::vector<double> shares;
  for (const double radius : radii) shares.push_back(mean > 0.0 ? std::clamp(radius / mean, 0.0, 1.0) : 1.0);
  return shares;
}

}  // namespace

struct MeasuredSurface::LazyDeviations {
  std::once_flag made;
  std::vector<Eigen::VectorXd> all;
};

MeasuredSurface::MeasuredSurface(const SurfaceSegment& segment)
    : segment_(&segment), deviations_(std::make_shared<LazyDeviations>()) {}

const std::vector<Eigen::VectorXd>& MeasuredSurface::Deviations() const {
  std::call_once(deviations_->made, [this] { deviations_->all = DrawDeviations(); });
  return deviations_->all;
}

std::vector<Eigen::VectorXd> MeasuredSurface::DrawDeviations() const {
  std::vector<Eigen::VectorXd> all;
  if (covariance_ == nullptr) return all;
  const auto width = static_cast<Eigen::Index>(surface().theta_basis().count());
  const std::vector<double> shares = ShareByHeight(surface());
  const double detail = segment_->detail_sigma / std::sqrt(kSquaresOfSplines);
  Signs signs(kDeviationSeed);
  for (std::size_t k = 0; k < kDeviations; ++k) {
    Eigen::VectorXd deviation = covariance_->Deviation(signs.Next(segment_->normal_matrix.cols()));
    if (segment_->hierarchy != nullptr) deviation = segment_->hierarchy->Surface(deviation).coefficients();
    if (detail > 0.0) deviation += detail * signs.Next(deviation.size());
    for (std::size_t j = 0; j < shares.size(); ++j) {
      deviation.segment(static_cast<Eigen::Index>(j) * width, width) *= shares[j];
    }
    all.push_back(std::move(deviation));
  }
  return all;
}

Result<MeasuredSurface> MeasuredSurface::FromModel(const SurfaceModel& model) {
  MeasuredSurface body(model.main());
  if (model.systematic) body.systematic_ = &*model.systematic;
  const Eigen::SparseMatrix<double>& precision = model.main().normal_matrix;
  if (precision.nonZeros() > 0) {
    auto covariance = model.main().hierarchy == nullptr
                          ? SurfaceCovariance::FromNormalMatrix(precision)
                          : SurfaceCovariance::FromNormalMatrix(precision, *model.main().hierarchy);
    if (!covariance) return Fail(covariance);
    body.covariance_ = std::make_shared<const SurfaceCovariance>(std::move(*covariance));
  }
  return body;
}

Uncertain MeasuredSurface::WithSigma(const Estimate& estimate) const { return WithSigmas({estimate}).front(); }

std::vector<Uncertain> MeasuredSurface::WithSigmas(const std::vector<Estimate>& estimates) const {
  std::vector<Uncertain> numbers;
  if (covariance_ == nullptr) {
    for (const Estimate& e : estimates) numbers.push_back({e.value, std::numeric_limits<double>::quiet_NaN()});
    return numbers;
  }
  std::vector<Eigen::VectorXd> gradients;
  for (const Estimate& e : estimates) {
    const Eigen::VectorXd gradient =
        e.gradient.size() > 0 ? Eigen::VectorXd(e.gradient) : Eigen::VectorXd::Zero(surface().coefficients().size());
    gradients.push_back(segment_->hierarchy == nullptr ? gradient : segment_->hierarchy->ActiveGradient(gradient));
  }
  const std::vector<double> posterior = covariance_->Variances(gradients);
  const double detail_variance = segment_->detail_sigma * segment_->detail_sigma / kSquaresOfSplines;
  for (std::size_t k = 0; k < estimates.size(); ++k) {
    const Estimate& e = estimates[k];
    const double detail = e.gradient.size() > 0 ? detail_variance * e.gradient.squaredNorm() : 0.0;
    numbers.push_back({e.value, std::sqrt(posterior[k] + detail + e.unresolved * e.unresolved)});
  }
  return numbers;
}

double MeasuredSurface::RadiusSigma(double theta, double z) const {
  if (covariance_ == nullptr) return std::numeric_limits<double>::quiet_NaN();
  std::vector<CoefficientWeight> gradient;
  if (segment_->hierarchy == nullptr) {
    const RadiusRow row = surface().Row(theta, z);
    for (std::size_t k = 0; k < row.index.size(); ++k) gradient.push_back({row.index[k], row.value[k]});
  } else {
    gradient = segment_->hierarchy->ActiveRow(theta, z);
  }
  return std::sqrt(covariance_->LocalVariance(gradient) + segment_->detail_sigma * segment_->detail_sigma);
}

double MeasuredSurface::Radius(double theta, double z) const {
  return segment_->paper ? segment_->paper->surface.Radius(theta, z) : surface().Radius(theta, z);
}

Eigen::Vector3d MeasuredSurface::Point(double theta, double z) const {
  return segment_->paper ? segment_->paper->surface.Point(theta, z) : surface().Point(theta, z);
}

Eigen::Vector3d MeasuredSurface::Normal(double theta, double z) const {
  return segment_->paper ? segment_->paper->surface.Normal(theta, z) : surface().Normal(theta, z);
}

}  // namespace annulus
