#include "modeling/measure/section.h"

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <string>

#include "base/frames.h"
#include "fitting/paper_model.h"
#include "modeling/measure/gauss.h"
#include "modeling/mesh/convex_hull_2d.h"

namespace annulus {
namespace {

constexpr std::size_t kTapePoints = 1440;
/// Mean of Σ (N_i N_j)² over the plane for uniform cubic B-splines: (∫N²)², ∫N² = 151/315.
constexpr double kSquaresOfSplines = (151.0 / 315.0) * (151.0 / 315.0);

std::string Text(double value) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.6g", value);
  return text.data();
}

Status CheckInRange(const MeasuredSurface& body, double z, const std::string& attempted) {
  const SplineSurface& s = body.surface();
  if (z >= s.z_min() && z <= s.z_max()) return {};
  return Fail(attempted, "z = " + Text(z) + " mm is outside the scanned range",
              "choose z from " + Text(s.z_min()) + " to " + Text(s.z_max()) + " mm");
}

/// Breaks of the theta pieces over one turn.
std::vector<double> ThetaBreaks(const SplineSurface& surface) {
  std::vector<double> breaks;
  for (std::size_t i = 0; i <= surface.theta_basis().count(); ++i) {
    breaks.push_back(static_cast<double>(i) * surface.theta_basis().spacing());
  }
  return breaks;
}

/// Shares of a set of places that are measured and unknown.
struct KnowledgeShares {
  double measured = 0.0;
  double unknown = 0.0;
};

KnowledgeShares SharesOfRow(const MeasuredSurface& body, double z) {
  const std::size_t columns = std::max<std::size_t>(1, body.segment().knowledge.columns());
  std::size_t measured = 0;
  std::size_t unknown = 0;
  for (std::size_t column = 0; column < columns; ++column) {
    const Knowledge k = body.KnowledgeAt(kTwoPi * static_cast<double>(column) / static_cast<double>(columns), z);
    if (k == Knowledge::kMeasured) ++measured;
    if (k == Knowledge::kUnknown) ++unknown;
  }
  return {static_cast<double>(measured) / static_cast<double>(columns),
          static_cast<double>(unknown) / static_cast<double>(columns)};
}

/// Every row of the knowledge map that the slab cuts, by the height it takes of it.
KnowledgeShares SharesOfSlab(const MeasuredSurface& body, double z_min, double z_max) {
  const KnowledgeMap& map = body.segment().knowledge;
  const auto rows = static_cast<double>(map.rows());
  std::vector<double> edges;
  for (double row = 0.0; row <= rows; row += 1.0) {
    edges.push_back(map.z_min() + (map.z_max() - map.z_min()) * row / std::max(rows, 1.0));
  }
  const std::vector<double> breaks = ClipBreaks(edges, z_min, z_max);
  KnowledgeShares shares;
  for (std::size_t k = 0; k + 1 < breaks.size(); ++k) {
    const KnowledgeShares row = SharesOfRow(body, 0.5 * (breaks[k] + breaks[k + 1]));
    const double height = (breaks[k + 1] - breaks[k]) / (z_max - z_min);
    shares.measured += height * row.measured;
    shares.unknown += height * row.unknown;
  }
  return shares;
}

Status CheckKnown(const KnowledgeShares& shares, const std::string& attempted) {
  if (shares.unknown == 0.0) return {};
  return Fail(attempted, Text(std::ceil(1000.0 * shares.unknown) / 10.0) + " % of it was not seen",
              "choose a place that the ring saw all around (it is not one visible loop here), or scan again");
}

void AddRow(const RadiusRow& row, double by_r, double by_theta, double by_z, Eigen::VectorXd& gradient) {
  for (std::size_t k = 0; k < row.index.size(); ++k) {
    gradient[static_cast<Eigen::Index>(row.index[k])] +=
        by_r * row.value[k] + by_theta * row.theta[k] + by_z * row.z[k];
  }
}

/// r, r_theta, r_z from the row and the coefficients.
struct Slopes {
  double r = 0.0;
  double theta = 0.0;
  double z = 0.0;
};

Slopes Apply(const RadiusRow& row, const Eigen::VectorXd& c) {
  Slopes s;
  for (std::size_t k = 0; k < row.index.size(); ++k) {
    const double coefficient = c[static_cast<Eigen::Index>(row.index[k])];
    s.r += row.value[k] * coefficient;
    s.theta += row.theta[k] * coefficient;
    s.z += row.z[k] * coefficient;
  }
  return s;
}

/// Length of a closed or open polygon through points that move along given directions with the surface's radius:
/// the value and its gradient.
struct ChainPoint {
  Eigen::Vector2d point;
  Eigen::Vector2d by_radius;  ///< d(point)/dr
  double theta = 0.0;
  double z = 0.0;
};

Uncertain ChainLength(const MeasuredSurface& body, const std::vector<ChainPoint>& chain, bool closed) {
  Eigen::VectorXd gradient = Eigen::VectorXd::Zero(body.surface().coefficients().size());
  double length = 0.0;
  const std::size_t n = chain.size();
  const std::size_t edges = closed ? n : n - 1;
  for (std::size_t k = 0; k < edges; ++k) {
    const ChainPoint& a = chain[k];
    const ChainPoint& b = chain[(k + 1) % n];
    const Eigen::Vector2d edge = b.point - a.point;
    const double step = edge.norm();
    if (step == 0.0) continue;
    length += step;
    AddRow(body.surface().Row(b.theta, b.z), edge.dot(b.by_radius) / step, 0.0, 0.0, gradient);
    AddRow(body.surface().Row(a.theta, a.z), -edge.dot(a.by_radius) / step, 0.0, 0.0, gradient);
  }
  return body.WithSigma(length, gradient);
}

/// Directions in which the tape may touch, rad. Between two sensor directions the surface is dense, but not beside a
/// step (slope over 45 degrees: the edge of an ear, an arm before the body), where a smooth curve swings over the edge
/// that no sensor saw: there only the sensors' own directions count.
std::vector<double> TapeDirections(const MeasuredSurface& body, double z) {
  const std::size_t columns = std::max<std::size_t>(8, body.segment().knowledge.columns());
  const double step = kTwoPi / static_cast<double>(columns);
  const std::size_t between = std::max<std::size_t>(1, (kTapePoints + columns - 1) / columns);
  std::vector<double> radius(columns);
  for (std::size_t k = 0; k < columns; ++k) radius[k] = body.surface().Radius(static_cast<double>(k) * step, z);
  std::vector<char> steep(columns);  // from column k to the next
  for (std::size_t k = 0; k < columns; ++k) {
    const double next = radius[(k + 1) % columns];
    steep[k] = std::abs(next - radius[k]) > 0.5 * (next + radius[k]) * step ? 1 : 0;
  }
  std::vector<double> directions;
  for (std::size_t k = 0; k < columns; ++k) {
    const bool beside = steep[(k + columns - 1) % columns] != 0 || steep[k] != 0 || steep[(k + 1) % columns] != 0;
    for (std::size_t j = 0; j < (beside ? 1 : between); ++j) {
      directions.push_back((static_cast<double>(k) + static_cast<double>(j) / static_cast<double>(between)) * step);
    }
  }
  return directions;
}

Uncertain TapeOfSection(const MeasuredSurface& body, double z) {
  std::vector<ChainPoint> curve;
  std::vector<Eigen::Vector2d> points;
  for (const double theta : TapeDirections(body, z)) {
    const Eigen::Vector2d direction(std::cos(theta), std::sin(theta));
    curve.push_back({body.surface().Radius(theta, z) * direction, direction, theta, z});
    points.push_back(curve.back().point);
  }
  // The hull's corners are points of the curve, to the bit.
  const std::vector<Eigen::Vector2d> hull = ConvexHull(points);
  std::vector<ChainPoint> corners;
  for (const Eigen::Vector2d& corner : hull) {
    for (const ChainPoint& candidate : curve) {
      if (candidate.point == corner) {
        corners.push_back(candidate);
        break;
      }
    }
  }
  return ChainLength(body, corners, true);
}

/// The meridian as a chain in the (r, z) half plane.
std::vector<ChainPoint> MeridianChain(const MeasuredSurface& body, double theta, double z_min, double z_max) {
  const auto steps = static_cast<std::size_t>(std::clamp((z_max - z_min) / 0.25, 16.0, 8192.0));
  std::vector<ChainPoint> chain;
  for (std::size_t k = 0; k <= steps; ++k) {
    const double z = z_min + (z_max - z_min) * static_cast<double>(k) / static_cast<double>(steps);
    chain.push_back({{body.surface().Radius(theta, z), z}, {1.0, 0.0}, theta, z});
  }
  return chain;
}

Status CheckMeridian(const MeasuredSurface& body, double theta, double z_min, double z_max) {
  const std::string attempted = "measure along the surface at theta = " + Text(DegreesFromRadians(theta)) + " deg";
  RETURN_IF_ERROR(CheckInRange(body, z_min, attempted));
  RETURN_IF_ERROR(CheckInRange(body, z_max, attempted));
  if (!(z_min < z_max)) return Fail(attempted, "the ends are not one above the other", "give z_min below z_max");
  for (const ChainPoint& point : MeridianChain(body, theta, z_min, z_max)) {
    if (body.KnowledgeAt(theta, point.z) == Knowledge::kUnknown) {
      return Fail(attempted, "the surface at z = " + Text(point.z) + " mm was not seen", "choose another line");
    }
  }
  return {};
}

}  // namespace

Result<MeasuredSurface> MeasuredSurface::FromModel(const SurfaceModel& model) {
  MeasuredSurface body(model.main());
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

Uncertain MeasuredSurface::WithSigma(double value, const Eigen::VectorXd& gradient) const {
  if (covariance_ == nullptr) return {value, std::numeric_limits<double>::quiet_NaN()};
  const double posterior =
      covariance_->Variance(segment_->hierarchy == nullptr ? gradient : segment_->hierarchy->ActiveGradient(gradient));
  const double detail = segment_->detail_sigma * segment_->detail_sigma * gradient.squaredNorm() / kSquaresOfSplines;
  return {value, std::sqrt(posterior + detail)};
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

Result<SectionMeasures> MeasureSection(const MeasuredSurface& body, double z) {
  const std::string attempted = "measure the section at z = " + Text(z) + " mm";
  RETURN_IF_ERROR(CheckInRange(body, z, attempted));
  const KnowledgeShares shares = SharesOfRow(body, z);
  RETURN_IF_ERROR(CheckKnown(shares, attempted));

  const SplineSurface& surface = body.surface();
  const Eigen::Index n = surface.coefficients().size();
  Eigen::VectorXd perimeter_gradient = Eigen::VectorXd::Zero(n);
  Eigen::VectorXd area_gradient = Eigen::VectorXd::Zero(n);
  double perimeter = 0.0;
  double area = 0.0;
  for (const QuadratureNode& node : PiecewiseGauss(ThetaBreaks(surface))) {
    const RadiusRow row = surface.Row(node.x, z);
    const Slopes s = Apply(row, surface.coefficients());
    const double speed = std::hypot(s.r, s.theta);
    perimeter += node.weight * speed;
    area += node.weight * 0.5 * s.r * s.r;
    if (speed > 0.0) {
      AddRow(row, node.weight * s.r / speed, node.weight * s.theta / speed, 0.0, perimeter_gradient);
    }
    AddRow(row, node.weight * s.r, 0.0, 0.0, area_gradient);
  }
  SectionMeasures measures;
  measures.z = z;
  measures.perimeter = body.WithSigma(perimeter, perimeter_gradient);
  measures.tape = TapeOfSection(body, z);
  measures.area = body.WithSigma(area, area_gradient);
  measures.measured_share = shares.measured;
  return measures;
}

Result<std::vector<Eigen::Vector2d>> SectionCurve(const MeasuredSurface& body, double z, std::size_t points) {
  const std::string attempted = "draw the section at z = " + Text(z) + " mm";
  RETURN_IF_ERROR(CheckInRange(body, z, attempted));
  RETURN_IF_ERROR(CheckKnown(SharesOfRow(body, z), attempted));
  std::vector<Eigen::Vector2d> curve;
  for (std::size_t k = 0; k < points; ++k) {
    const double theta = kTwoPi * static_cast<double>(k) / static_cast<double>(points);
    curve.emplace_back(body.surface().Point(theta, z).head<2>());
  }
  return curve;
}

Result<SlabMeasures> MeasureSlab(const MeasuredSurface& body, double z_min, double z_max) {
  const std::string attempted = "measure the slab from z = " + Text(z_min) + " to " + Text(z_max) + " mm";
  if (!(z_min < z_max)) return Fail(attempted, "it has no height", "give --z-min below --z-max");
  RETURN_IF_ERROR(CheckInRange(body, z_min, attempted));
  RETURN_IF_ERROR(CheckInRange(body, z_max, attempted));

  const SplineSurface& surface = body.surface();
  const std::vector<double> breaks = ClipBreaks(surface.z_basis().breakpoints(), z_min, z_max);
  const KnowledgeShares shares = SharesOfSlab(body, z_min, z_max);
  RETURN_IF_ERROR(CheckKnown(shares, attempted));

  const Eigen::Index n = surface.coefficients().size();
  Eigen::VectorXd volume_gradient = Eigen::VectorXd::Zero(n);
  Eigen::VectorXd area_gradient = Eigen::VectorXd::Zero(n);
  double volume = 0.0;
  double area = 0.0;
  const std::vector<QuadratureNode> around = PiecewiseGauss(ThetaBreaks(surface));
  for (const QuadratureNode& up : PiecewiseGauss(breaks)) {
    for (const QuadratureNode& side : around) {
      const double weight = up.weight * side.weight;
      const RadiusRow row = surface.Row(side.x, up.x);
      const Slopes s = Apply(row, surface.coefficients());
      // |P_theta × P_z|² = r² + r_theta² + r² r_z²
      const double density = std::sqrt(s.r * s.r * (1.0 + s.z * s.z) + s.theta * s.theta);
      volume += weight * 0.5 * s.r * s.r;
      area += weight * density;
      AddRow(row, weight * s.r, 0.0, 0.0, volume_gradient);
      if (density > 0.0) {
        AddRow(row, weight * s.r * (1.0 + s.z * s.z) / density, weight * s.theta / density,
               weight * s.r * s.r * s.z / density, area_gradient);
      }
    }
  }
  return SlabMeasures{z_min, z_max, body.WithSigma(volume, volume_gradient), body.WithSigma(area, area_gradient),
                      shares.measured};
}

Result<Uncertain> MeridianLength(const MeasuredSurface& body, double theta, double z_min, double z_max) {
  RETURN_IF_ERROR(CheckMeridian(body, theta, z_min, z_max));
  return ChainLength(body, MeridianChain(body, theta, z_min, z_max), false);
}

Result<Uncertain> MeridianTape(const MeasuredSurface& body, double theta, double z_min, double z_max) {
  RETURN_IF_ERROR(CheckMeridian(body, theta, z_min, z_max));
  // The taut chain: from the lower end to the upper, turning only where the surface bulges outward (upper hull of r
  // over z, by the monotone chain).
  std::vector<ChainPoint> taut;
  for (const ChainPoint& point : MeridianChain(body, theta, z_min, z_max)) {
    while (taut.size() >= 2) {
      const Eigen::Vector2d last = taut.back().point - taut[taut.size() - 2].point;
      const Eigen::Vector2d next = point.point - taut.back().point;
      if (last.x() * next.y() - last.y() * next.x() > 0.0) break;  // bulges towards larger r
      taut.pop_back();
    }
    taut.push_back(point);
  }
  return ChainLength(body, taut, false);
}

}  // namespace annulus
