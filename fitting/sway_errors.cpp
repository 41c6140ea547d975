#include "fitting/sway_errors.h"

#include <Eigen/QR>
#include <algorithm>
#include <array>
#include <cmath>

#include "base/units.h"
#include "fitting/sweep_paths.h"

namespace annulus {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// The heights at which the surface's errors are stated, and what they are of the motion at the knots: the mean over
/// the sweeps that saw the height.
struct Sections {
  std::vector<double> heights;
  MatrixXd share;  ///< heights × knots, rows sum to 1.
};

Sections SectionsOf(const std::vector<SweptLevel>& levels, const SwayPosterior& posterior) {
  constexpr double kStep = 30.0;  // mm
  constexpr std::size_t kMost = 72;
  const SweepPaths paths(levels);
  double low = levels.front().z;
  double high = low;
  for (const SweptLevel& level : levels) {
    low = std::min(low, level.z);
    high = std::max(high, level.z);
  }
  const auto intervals =
      std::clamp<std::size_t>(static_cast<std::size_t>(std::ceil((high - low) / kStep)), 1, kMost - 1);
  const double step = (high - low) / static_cast<double>(intervals);
  Sections sections;
  sections.share = MatrixXd::Zero(static_cast<Index>(intervals + 1), static_cast<Index>(posterior.times.size()));
  for (std::size_t k = 0; k <= intervals; ++k) {
    const double z = low + step * static_cast<double>(k);
    const std::vector<double> times = paths.TimesAt(z, std::max(step, 20.0));
    if (times.empty()) continue;
    const auto row = static_cast<Index>(sections.heights.size());
    for (const double time : times) {
      const SwayPosterior::Place place = posterior.At(time);
      sections.share(row, static_cast<Index>(place.knot)) += (1.0 - place.share) / static_cast<double>(times.size());
      sections.share(row, static_cast<Index>(place.knot) + 1) += place.share / static_cast<double>(times.size());
    }
    sections.heights.push_back(z);
  }
  sections.share.conservativeResize(static_cast<Index>(sections.heights.size()), Eigen::NoChange);
  return sections;
}

/// Displacements of the sections by the motion at the knots: x, y (mm at their heights), yaw.
MatrixXd SectionsByMotion(const Sections& sections) {
  const Index n = sections.share.rows();
  const Index m = sections.share.cols();
  MatrixXd by = MatrixXd::Zero(3 * n, kSwayAxes * m);
  for (Index k = 0; k < n; ++k) {
    const double lean = sections.heights[static_cast<std::size_t>(k)] / kSwayHeight;
    for (Index a = 0; a < 2; ++a) {
      by.block(a * n + k, a * m, 1, m) = lean * sections.share.row(k);
      by.block(a * n + k, (3 + a) * m, 1, m) = sections.share.row(k);
    }
    by.block(2 * n + k, 2 * m, 1, m) = sections.share.row(k);
  }
  return by;
}

/// What is left of curves over the heights (one per column) when translation and lean are taken out.
MatrixXd WithoutRigid(const std::vector<double>& heights, const MatrixXd& curves) {
  MatrixXd rigid(curves.rows(), 2);
  for (Index k = 0; k < curves.rows(); ++k) rigid.row(k) << 1.0, 1e-3 * heights[static_cast<std::size_t>(k)];
  if (curves.rows() < 2) return MatrixXd::Zero(curves.rows(), curves.cols());
  return curves - rigid * rigid.colPivHouseholderQr().solve(curves);
}

double Rms(const MatrixXd& values) {
  return values.cols() == 0 || values.rows() == 0 ? 0.0 : std::sqrt(values.array().square().colwise().mean().mean());
}

/// RMS over heights and draws of the horizontal displacement, without translation and lean.
double ShapeRms(const std::vector<double>& heights, const MatrixXd& sections) {
  const Index n = static_cast<Index>(heights.size());
  return std::hypot(Rms(WithoutRigid(heights, sections.topRows(n))),
                    Rms(WithoutRigid(heights, sections.middleRows(n, n))));
}

/// The covariance of the sections' displacements about their means over the heights: where a body stands, and how it is
/// turned as a whole, is no error of anything that is measured on it.
MatrixXd WithoutCommon(const MatrixXd& covariance) {
  const Index n = covariance.rows() / 3;
  MatrixXd centre = MatrixXd::Identity(3 * n, 3 * n);
  for (Index a = 0; a < 3; ++a) centre.block(a * n, a * n, n, n).array() -= 1.0 / static_cast<double>(n);
  const MatrixXd rest = centre * covariance * centre.transpose();
  return 0.5 * (rest + rest.transpose());
}

/// The parametric form that comes closest, for readers that know no other: sds of the displacement without the mean,
/// and the length at which differences have the size that they have 200 mm apart.
void FillParameters(SwayErrors& errors) {
  const auto n = static_cast<Index>(errors.heights.size());
  const MatrixXd centre = MatrixXd::Identity(n, n) - MatrixXd::Constant(n, n, 1.0 / static_cast<double>(n));
  const auto sigma = [&](Index axis) {
    const MatrixXd c = errors.covariance.block(axis * n, axis * n, n, n);
    return std::sqrt(std::max(0.0, (centre * c * centre).trace() / static_cast<double>(n)));
  };
  errors.sigma_x = sigma(0);
  errors.sigma_y = sigma(1);
  constexpr double kLag = 200.0;  // mm
  const double whole = errors.sigma_x * errors.sigma_x + errors.sigma_y * errors.sigma_y;
  double difference = 0.0;
  double count = 0.0;
  for (Index i = 0; i < n; ++i) {
    for (Index j = 0; j < i; ++j) {
      const double lag = errors.heights[static_cast<std::size_t>(i)] - errors.heights[static_cast<std::size_t>(j)];
      if (std::abs(lag - kLag) > 0.25 * kLag) continue;
      for (Index a = 0; a < 2; ++a) {
        const Index p = a * n + i;
        const Index q = a * n + j;
        difference += errors.covariance(p, p) + errors.covariance(q, q) - 2.0 * errors.covariance(p, q);
      }
      count += 1.0;
    }
  }
  const double like = count > 0.0 && whole > 0.0 ? 1.0 - 0.5 * difference / count / whole : 0.9;  // exp(-lag²/2L²)
  errors.correlation_length = kLag / std::sqrt(-2.0 * std::log(std::clamp(like, 0.01, 0.99)));
}

SwayNumber NumberOf(std::vector<double> draws) {
  SwayNumber number;
  if (draws.empty()) return number;
  std::sort(draws.begin(), draws.end());
  for (const double draw : draws) number.value += draw;
  number.value /= static_cast<double>(draws.size());
  for (const double draw : draws) number.sigma += (draw - number.value) * (draw - number.value);
  number.sigma = std::sqrt(number.sigma / static_cast<double>(draws.size()));
  number.low95 = draws[draws.size() / 40];
  number.high95 = draws[draws.size() - 1 - draws.size() / 40];
  return number;
}

/// sd and range over time of the drawn motions of one axis.
std::array<SwayNumber, 2> OverTime(const MatrixXd& draws) {
  std::vector<double> sds;
  std::vector<double> ranges;
  for (Index k = 0; k < draws.cols(); ++k) {
    const VectorXd curve = draws.col(k);
    sds.push_back(std::sqrt((curve.array() - curve.mean()).square().mean()));
    ranges.push_back(curve.maxCoeff() - curve.minCoeff());
  }
  return {NumberOf(std::move(sds)), NumberOf(std::move(ranges))};
}

void FillLevels(const SwayAlignment& alignment, SwayEstimate& estimate) {
  const SwayPosterior& posterior = alignment.posterior;
  const auto n = static_cast<Index>(posterior.times.size());
  double removed = 0.0;
  for (std::size_t k = 0; k < alignment.levels.size(); ++k) {
    const SweptLevel& level = alignment.levels[k];
    const SwayPosterior::Place place = posterior.At(level.time_s);
    const auto sigma = [&](Index axis) {
      const Index at = axis * n + static_cast<Index>(place.knot);
      const Eigen::Vector2d by(1.0 - place.share, place.share);
      return std::sqrt(std::max(0.0, by.dot(posterior.covariance.block<2, 2>(at, at) * by)));
    };
    estimate.levels.push_back({level.sweep,
                               level.level,
                               level.time_s,
                               level.z,
                               alignment.moved[k],
                               {sigma(0), sigma(1), sigma(2), sigma(3), sigma(4)}});
    removed += alignment.moved[k].At(level.z).squaredNorm();
  }
  estimate.summary.removed_mm = std::sqrt(removed / static_cast<double>(alignment.levels.size()));
}

}  // namespace

void FillSway(const SwayAlignment& alignment, SwayEstimate& estimate) {
  FillLevels(alignment, estimate);
  const SwayPosterior& posterior = alignment.posterior;
  const auto n = static_cast<Index>(posterior.times.size());
  SwaySummary& summary = estimate.summary;
  summary.scale = posterior.scale;
  const MatrixXd& draws = posterior.draws;
  const auto x = OverTime(draws.middleRows(0, n) + draws.middleRows(3 * n, n));
  const auto y = OverTime(draws.middleRows(n, n) + draws.middleRows(4 * n, n));
  summary.sd_x = x[0];
  summary.range_x = x[1];
  summary.sd_y = y[0];
  summary.range_y = y[1];
  summary.sd_yaw = OverTime(draws.middleRows(2 * n, n))[0];
  const Sections sections = SectionsOf(alignment.levels, posterior);
  if (sections.heights.size() < 2) return;
  const MatrixXd by = SectionsByMotion(sections);
  // What the mean of the sweeps is displaced by: of it, only what fixed sensors saw was taken out.
  const VectorXd mean = by * posterior.mean;
  const VectorXd out = alignment.common == CommonPart::kTakenOut ? mean : VectorXd::Zero(mean.size());
  SwayErrors errors;
  errors.heights = sections.heights;
  errors.covariance = by * posterior.covariance * by.transpose() + (mean - out) * (mean - out).transpose();
  errors.covariance = WithoutCommon(errors.covariance);
  FillParameters(errors);
  summary.unremoved_mm = ShapeRms(sections.heights, by * draws);
  summary.remaining_mm = ShapeRms(sections.heights, (by * draws).colwise() - out);
  estimate.errors = std::move(errors);
}

}  // namespace annulus
