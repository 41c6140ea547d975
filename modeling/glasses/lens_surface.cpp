#include "modeling/glasses/lens_surface.h"

#include <cmath>
#include <limits>

namespace annulus {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr int kMostSteps = 30;
constexpr double kStepDone = 1e-13;  // mm
constexpr double kOnSurface = 1e-9;  // mm

/// Sag h of the tyre torus and its derivatives at (u, v). With g the sag of the generating circle, W = 1 − b·g and
/// Q = √(W² − b²v²): h = g + b·v² / (W + Q), which holds for every sign of a and b, and for 0.
struct TorusSag {
  double h;
  double hu, hv;
  double huu, huv, hvv;
};

double SagOnly(double a, double b, double u, double v) {
  const double s2 = 1.0 - a * a * u * u;
  if (!(s2 > 0.0)) return kNaN;
  const double g = a * u * u / (1.0 + std::sqrt(s2));
  const double w = 1.0 - b * g;
  const double q2 = w * w - b * b * v * v;
  if (!(w > 0.0 && q2 > 0.0)) return kNaN;
  return g + b * v * v / (w + std::sqrt(q2));
}

TorusSag SagAndDerivatives(double a, double b, double u, double v) {
  const double s2 = 1.0 - a * a * u * u;
  const double s = std::sqrt(s2);
  const double g = a * u * u / (1.0 + s);
  const double gu = a * u / s;
  const double guu = a / (s2 * s);
  const double w = 1.0 - b * g;
  const double q2 = w * w - b * b * v * v;
  if (!(s2 > 0.0 && w > 0.0 && q2 > 0.0)) return {kNaN, kNaN, kNaN, kNaN, kNaN, kNaN};
  const double q = std::sqrt(q2);
  const double q3 = q2 * q;
  return {g + b * v * v / (w + q), w * gu / q,    b * v / q, (w * guu - b * gu * gu) / q + b * w * w * gu * gu / q3,
          w * gu * b * b * v / q3, b * w * w / q3};
}

/// The parameter t at which origin + t·direction (surface frame) meets the torus near its vertex; NaN if it does not.
double MeetInSurface(double a, double b, const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) {
  if (direction.z() == 0.0) return kNaN;
  // Start: the sphere of mean curvature c, w + c/2·|p|² = 0, from the point in the vertex plane on.
  const double plane = -origin.z() / direction.z();
  const Eigen::Vector3d base = origin + plane * direction;
  const double c = 0.5 * (a + b);
  const double half_b = 0.5 * (direction.z() + c * base.dot(direction));
  const double quadratic = 0.5 * c * direction.squaredNorm();
  const double constant = 0.5 * c * base.squaredNorm();
  const double discriminant = half_b * half_b - quadratic * constant;
  double t = plane;
  if (discriminant >= 0.0) t -= constant / (half_b + std::copysign(std::sqrt(discriminant), half_b));
  for (int step = 0; step < kMostSteps; ++step) {
    const Eigen::Vector3d p = origin + t * direction;
    const TorusSag sag = SagAndDerivatives(a, b, p.x(), p.y());
    const double miss = p.z() + sag.h;
    const double change = miss / (direction.z() + sag.hu * direction.x() + sag.hv * direction.y());
    if (!std::isfinite(change)) return kNaN;
    t -= change;
    if (std::abs(change) < kStepDone * (1.0 + std::abs(t))) return t;
  }
  const Eigen::Vector3d p = origin + t * direction;
  return std::abs(p.z() + SagOnly(a, b, p.x(), p.y())) < kOnSurface ? t : kNaN;
}

}  // namespace

double LensSurface::SagInSurface(double u, double v) const { return SagOnly(curvature_u, curvature_v, u, v); }

double LensSurface::Sag(double x, double y) const {
  const Eigen::Matrix3d& rotation = lens_from_surface.linear();
  const Eigen::Vector3d& vertex = lens_from_surface.translation();
  const double dx = x - vertex.x();
  const double dy = y - vertex.y();
  if (rotation(2, 2) == 1.0) {  // upright: no search
    return vertex.z() - SagOnly(curvature_u, curvature_v, rotation(0, 0) * dx + rotation(1, 0) * dy,
                                rotation(0, 1) * dx + rotation(1, 1) * dy);
  }
  const Eigen::Vector3d origin = rotation.transpose() * Eigen::Vector3d(dx, dy, 0.0);
  return vertex.z() + MeetInSurface(curvature_u, curvature_v, origin, rotation.row(2).transpose());
}

std::optional<SurfaceHit> Meet(const LensSurface& surface, const Eigen::Vector3d& origin,
                               const Eigen::Vector3d& direction) {
  const Eigen::Matrix3d& rotation = surface.lens_from_surface.linear();
  const Eigen::Vector3d local_origin = rotation.transpose() * (origin - surface.lens_from_surface.translation());
  const Eigen::Vector3d local_direction = rotation.transpose() * direction;
  const double t = MeetInSurface(surface.curvature_u, surface.curvature_v, local_origin, local_direction);
  if (!std::isfinite(t)) return std::nullopt;
  const Eigen::Vector3d p = local_origin + t * local_direction;
  const TorusSag sag = SagAndDerivatives(surface.curvature_u, surface.curvature_v, p.x(), p.y());
  if (!std::isfinite(sag.h)) return std::nullopt;
  // The surface is F = w + h(u, v) = 0: normal ∇F / |∇F|, shape operator P·∇∇F·P / |∇F|.
  const Eigen::Vector3d gradient(sag.hu, sag.hv, 1.0);
  const double length = gradient.norm();
  const Eigen::Vector3d normal = gradient / length;
  Eigen::Matrix3d hessian = Eigen::Matrix3d::Zero();
  hessian.topLeftCorner<2, 2>() << sag.huu, sag.huv, sag.huv, sag.hvv;
  const Eigen::Matrix3d tangent = Eigen::Matrix3d::Identity() - normal * normal.transpose();
  const Eigen::Matrix3d shape = tangent * hessian * tangent / length;
  return SurfaceHit{origin + t * direction, rotation * normal, rotation * shape * rotation.transpose()};
}

}  // namespace annulus
