#include "modeling/measure/closest_point.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "base/ensure.h"
#include "base/frames.h"
#include "modeling/measure/number_text.h"
#include "modeling/measure/place_check.h"
#include "modeling/measure/surface_derivatives.h"

namespace annulus {
namespace {

constexpr double kFarthest = 1e6;       // mm from the origin: beyond, squares of distances lose the surface
constexpr double kSameDistance = 1e-9;  // mm
constexpr int kNewtonSteps = 40;

/// Smallest and largest coefficient under each patch: the patch's radii lie between them. Patch (i, j) is theta
/// interval i by z interval j.
struct PatchRadii {
  std::vector<double> low;
  std::vector<double> high;
};

/// By sliding windows of four, first over theta, then over z.
PatchRadii RadiiOfPatches(const SplineSurface& surface) {
  const std::size_t width = surface.theta_basis().count();
  const std::size_t rows = surface.z_basis().count();
  std::vector<double> low(width * rows);
  std::vector<double> high(width * rows);
  for (std::size_t j = 0; j < rows; ++j) {
    const double* c = surface.coefficients().data() + j * width;
    for (std::size_t i = 0; i < width; ++i) {  // interval i: splines i - 1 … i + 2
      const auto [least, most] =
          std::minmax({c[(i + width - 1) % width], c[i], c[(i + 1) % width], c[(i + 2) % width]});
      low[j * width + i] = least;
      high[j * width + i] = most;
    }
  }
  PatchRadii radii;
  for (std::size_t k = 0; k < width * (rows - 3); ++k) {  // interval j: splines j … j + 3
    radii.low.push_back(std::min({low[k], low[k + width], low[k + 2 * width], low[k + 3 * width]}));
    radii.high.push_back(std::max({high[k], high[k + width], high[k + 2 * width], high[k + 3 * width]}));
  }
  return radii;
}

/// The part of (theta, z) between knots.
struct Patch {
  double theta_low = 0.0;
  double theta_high = 0.0;
  double z_low = 0.0;
  double z_high = 0.0;

  [[nodiscard]] SurfacePlace At(double u, double v) const {
    return {theta_low + u * (theta_high - theta_low), z_low + v * (z_high - z_low)};
  }
};

/// A place and the square of its distance.
struct Candidate {
  SurfacePlace place;
  double square = std::numeric_limits<double>::infinity();
};

/// Search over all patches for one point.
class NearestSearch {
 public:
  NearestSearch(const SplineSurface& surface, const Eigen::Vector3d& point)
      : surface_(surface), point_(point), point_radius_(point.head<2>().norm()) {
    const double spacing = surface.theta_basis().spacing();
    const double theta = point_radius_ > 0.0 ? std::atan2(point.y(), point.x()) : 0.0;
    for (std::size_t i = 0; i < surface.theta_basis().count(); ++i) {
      const double middle = (static_cast<double>(i) + 0.5) * spacing;
      const double aside = std::max(0.0, std::abs(AngleDifference(theta, middle)) - 0.5 * spacing);
      cosine_.push_back(std::cos(aside));
    }
  }

  /// The nearest place. Patches are taken from the lowest up, and around; a later one must be nearer.
  [[nodiscard]] SurfacePlace Find() {
    const PatchRadii radii = RadiiOfPatches(surface_);
    const std::vector<double>& breaks = surface_.z_basis().breakpoints();
    const std::size_t width = cosine_.size();
    const double bound = std::sqrt(NearestCorner()) + kSameDistance;
    double limit = bound * bound;
    for (std::size_t j = 0; j + 1 < breaks.size(); ++j) {
      for (std::size_t i = 0; i < width; ++i) {
        const std::size_t k = j * width + i;
        if (BoxSquare(i, radii.low[k], radii.high[k], breaks[j], breaks[j + 1]) > limit) continue;
        const double spacing = surface_.theta_basis().spacing();
        const double start = static_cast<double>(i) * spacing;
        const Candidate found = NearestIn({start, start + spacing, breaks[j], breaks[j + 1]});
        if (std::sqrt(found.square) >= std::sqrt(best_.square) - kSameDistance) continue;
        best_ = found;
        limit = std::min(limit, best_.square);
      }
    }
    ENSURE(std::isfinite(best_.square), "the patch of the nearest corner was searched");
    return best_.place;
  }

 private:
  [[nodiscard]] double Square(const SurfacePlace& place) const {
    return (surface_.Point(place.theta, place.z) - point_).squaredNorm();
  }

  /// Square of the least distance of every second knot crossing: a first bound.
  [[nodiscard]] double NearestCorner() const {
    const std::vector<double>& breaks = surface_.z_basis().breakpoints();
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t j = 0; j < breaks.size(); j += 2) {
      for (std::size_t i = 0; i < cosine_.size(); i += 2) {
        least = std::min(least, Square({static_cast<double>(i) * surface_.theta_basis().spacing(), breaks[j]}));
      }
    }
    return least;
  }

  /// Square of the distance of the point from everything in theta interval i with radii low … high at z_low … z_high.
  [[nodiscard]] double BoxSquare(std::size_t i, double low, double high, double z_low, double z_high) const {
    const double up = point_.z() - std::clamp(point_.z(), z_low, z_high);
    // From the ray nearest in angle: r² + p² - 2 r p cos, least at r = p cos. A negative radius is on the other side.
    if (low < 0.0) return up * up;
    const double r = std::clamp(point_radius_ * cosine_[i], low, high);
    const double along = r - point_radius_ * cosine_[i];
    const double aside = point_radius_ * std::sqrt(std::max(0.0, 1.0 - cosine_[i] * cosine_[i]));
    return along * along + aside * aside + up * up;
  }

  /// The nearest place within a patch: from the nearest of nine, by Newton's rule held within the patch.
  [[nodiscard]] Candidate NearestIn(const Patch& patch) const {
    Candidate best;
    for (const double v : {0.0, 0.5, 1.0}) {
      for (const double u : {0.0, 0.5, 1.0}) {
        const SurfacePlace place = patch.At(u, v);
        const double square = Square(place);
        if (square < best.square) best = {place, square};
      }
    }
    for (int k = 0; k < kNewtonSteps; ++k) {
      const SurfacePlace next = NewtonStep(patch, best);
      if (next.theta == best.place.theta && next.z == best.place.z) break;
      best = {next, Square(next)};
    }
    return best;
  }

  /// A place of the patch nearer than `from`, or `from` itself if there is none to be found.
  [[nodiscard]] SurfacePlace NewtonStep(const Patch& patch, const Candidate& from) const {
    const SurfaceDerivatives p = DerivativesAt(surface_, from.place);
    const Eigen::Vector3d away = p.position - point_;
    Eigen::Vector2d slope(p.by_theta.dot(away), p.by_z.dot(away));
    Eigen::Matrix2d metric;
    metric << p.by_theta.squaredNorm(), p.by_theta.dot(p.by_z), p.by_theta.dot(p.by_z), p.by_z.squaredNorm();
    Eigen::Matrix2d bend;
    bend << p.by_theta_theta.dot(away), p.by_theta_z.dot(away), p.by_theta_z.dot(away), p.by_z_z.dot(away);
    // The second derivatives if they are positive definite, else without what the surface's bending adds.
    Eigen::Matrix2d hessian = metric + bend;
    if (!(hessian(0, 0) > 0.0 && hessian.determinant() > 1e-6 * metric.determinant())) hessian = metric;
    // At an edge of the patch that the way leads out of, only the way along the edge counts.
    const bool theta_held = (from.place.theta <= patch.theta_low && slope[0] > 0.0) ||
                            (from.place.theta >= patch.theta_high && slope[0] < 0.0);
    const bool z_held =
        (from.place.z <= patch.z_low && slope[1] > 0.0) || (from.place.z >= patch.z_high && slope[1] < 0.0);
    Eigen::Vector2d way = -hessian.inverse() * slope;
    if (theta_held) way = {0.0, -slope[1] / hessian(1, 1)};
    if (z_held) way = {theta_held ? 0.0 : -slope[0] / hessian(0, 0), 0.0};
    if (way.dot(metric * way) < kSameDistance * kSameDistance) return from.place;
    for (double part = 1.0; part > 1e-6; part *= 0.5) {
      const SurfacePlace next{std::clamp(from.place.theta + part * way[0], patch.theta_low, patch.theta_high),
                              std::clamp(from.place.z + part * way[1], patch.z_low, patch.z_high)};
      if (Square(next) < from.square) return next;
    }
    return from.place;
  }

  const SplineSurface& surface_;
  Eigen::Vector3d point_;
  double point_radius_;
  std::vector<double> cosine_;  // of the angle between the point and the nearest ray of each theta interval
  Candidate best_;
};

/// By the envelope theorem only the radius at the nearest place counts: moving along the surface changes nothing.
Estimate SignedDistance(const SplineSurface& surface, const Eigen::Vector3d& point, const SurfacePlace& nearest) {
  const Eigen::Vector3d away = point - surface.Point(nearest.theta, nearest.z);
  const double distance = away.norm();
  const double theta = std::atan2(point.y(), point.x());
  const bool inside = point.z() >= surface.z_min() && point.z() <= surface.z_max() &&
                      point.head<2>().norm() < surface.Radius(theta, point.z());
  const double sign = inside ? -1.0 : 1.0;
  // On the surface itself the distance has no direction, but the signed distance has: the normal's.
  const Eigen::Vector3d direction =
      distance > kSameDistance ? Eigen::Vector3d(sign * away / distance) : surface.Normal(nearest.theta, nearest.z);
  GradientSum gradient(surface);
  gradient.AddRadius(nearest.theta, nearest.z,
                     -direction.dot(Eigen::Vector3d(std::cos(nearest.theta), std::sin(nearest.theta), 0.0)));
  return {sign * distance, gradient.Get()};
}

}  // namespace

Result<ClosestPoint> NearestOnSurface(const MeasuredSurface& body, const Eigen::Vector3d& p_in_station) {
  const std::string attempted = "find the nearest place to (" + NumberText(p_in_station.x()) + ", " +
                                NumberText(p_in_station.y()) + ", " + NumberText(p_in_station.z()) + ") mm";
  if (!(p_in_station.cwiseAbs().maxCoeff() <= kFarthest) || !p_in_station.allFinite()) {
    return Fail(attempted, "the point is not finite, or too far away", "give a point in the booth");
  }
  const SplineSurface& surface = body.surface();
  SurfacePlace place = NearestSearch(surface, p_in_station).Find();
  place.theta = WrapAngle(place.theta);
  const Knowledge knowledge = body.KnowledgeAt(place.theta, place.z);
  if (knowledge == Knowledge::kUnknown) {
    return Fail(attempted, "the surface at " + PlaceText(place) + " was not seen",
                "choose a point near what was scanned");
  }
  const bool at_end = place.z <= surface.z_min() || place.z >= surface.z_max();
  return ClosestPoint{place, surface.Point(place.theta, place.z), at_end ? NearestPlace::kAtEnd : NearestPlace::kWithin,
                      knowledge, SignedDistance(surface, p_in_station, place)};
}

}  // namespace annulus
