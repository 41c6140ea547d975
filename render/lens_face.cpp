#include "render/lens_face.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace annulus {
namespace {

/// Sines of the slope up to which the sag is the torus' own; beyond, it goes on straight, so that Newton's method and
/// the bound of its bending do not break down at the torus' rim.
constexpr double kSteepest = 0.9999;
constexpr double kFlank = 0.014141782065920829;  // √(1 − kSteepest²)
constexpr double kNarrowest = 1e-9;              // mm: two roots as near as this are none
constexpr double kStepDone = 1e-13;              // mm
constexpr double kNearlyDone = 1e-7;             // mm
constexpr int kMostSteps = 60;

struct Sag {
  double h;
  double hu, hv;
};

/// Sag of the tyre torus (lens_surface.h) of curvatures a and b, and its slopes: with g the sag of the generating
/// circle, W = 1 − b·g and Q = √(W² − b²v²) it is (1 − Q)/b.
Sag SagAt(double a, double b, double u, double v) {
  const double x = a * u;
  double g = 0.0;
  double gu = 0.0;
  if (std::abs(x) <= kSteepest) {
    const double s = std::sqrt(1.0 - x * x);
    g = x * u / (1.0 + s);
    gu = x / s;
  } else {
    gu = std::copysign(kSteepest / kFlank, x);
    g = (1.0 - kFlank) / a + gu * (u - std::copysign(kSteepest / std::abs(a), u));
  }
  const double w = 1.0 - b * g;
  const double y = b * v;
  if (std::abs(y) <= kSteepest * w) {
    const double q = std::sqrt(w * w - y * y);
    return {g + y * v / (w + q), w * gu / q, y / q};
  }
  const double q = (w - kSteepest * std::abs(y)) / kFlank;
  return {(1.0 - q) / b, gu / kFlank, std::copysign(kSteepest / kFlank, y)};
}

/// The norm of the sag's Hessian, 0 beyond the torus.
double BendingAt(double a, double b, double u, double v) {
  const double x = a * u;
  if (std::abs(x) > kSteepest) return 0.0;
  const double s = std::sqrt(1.0 - x * x);
  const double g = x * u / (1.0 + s);
  const double gu = x / s;
  const double w = 1.0 - b * g;
  if (std::abs(b * v) > kSteepest * w) return 0.0;
  const double q = std::sqrt(w * w - b * b * v * v);
  const double q3 = q * q * q;
  const double huu = (w * a / (s * s * s) - b * gu * gu) / q + b * w * w * gu * gu / q3;
  const double huv = w * gu * b * b * v / q3;
  const double hvv = b * w * w / q3;
  return std::sqrt(huu * huu + 2.0 * huv * huv + hvv * hvv);
}

/// f(t) = w + h(u, v) along a ray in the surface frame.
struct TorusOnRay {
  double a;
  double b;
  Eigen::Vector3d origin;
  Eigen::Vector3d direction;
  double bending;  // |f''| <= bending

  struct Value {
    double f;
    double slope;
  };
  [[nodiscard]] Value At(double t) const {
    const Eigen::Vector3d p = origin + t * direction;
    const Sag sag = SagAt(a, b, p.x(), p.y());
    return {p.z() + sag.h, direction.z() + sag.hu * direction.x() + sag.hv * direction.y()};
  }
};

struct End {
  double t;
  double f;
};

/// The root in a bracket of different signs: Newton's method from `t`, halving where it would leave.
double RootIn(const TorusOnRay& torus, End low, End high, double t, TorusOnRay::Value value) {
  for (int step = 0; step < kMostSteps; ++step) {
    (std::signbit(value.f) == std::signbit(low.f) ? low : high) = {t, value.f};
    double next = t - value.f / value.slope;
    if (!(next >= low.t && next <= high.t)) next = 0.5 * (low.t + high.t);
    const double change = std::abs(next - t);
    t = next;
    if (change < kStepDone * (1.0 + std::abs(t))) break;
    value = torus.At(t);
  }
  return t;
}

void Isolate(const TorusOnRay& torus, const End& low, const End& high, FaceRoots& roots) {
  const double length = high.t - low.t;
  const bool changes = std::signbit(low.f) != std::signbit(high.f);
  // |f − chord| <= bending · length² / 8
  const double nearest = std::min(std::abs(low.f), std::abs(high.f));
  if (!changes && nearest > 0.125 * torus.bending * length * length) return;
  const double middle = 0.5 * (low.t + high.t);
  const TorusOnRay::Value value = torus.At(middle);
  const bool is_monotone = std::abs(value.slope) > 0.5 * torus.bending * length;
  if (is_monotone || length < kNarrowest) {
    if (changes && roots.count < roots.t.size()) roots.t[roots.count++] = RootIn(torus, low, high, middle, value);
    return;
  }
  Isolate(torus, low, {middle, value.f}, roots);
  Isolate(torus, {middle, value.f}, high, roots);
}

/// Newton's method from `t` without a bracket; NaN if it is not there within few steps.
double NewtonFrom(const TorusOnRay& torus, double t, TorusOnRay::Value value) {
  constexpr int kFewSteps = 6;
  for (int step = 0; step < kFewSteps; ++step) {
    const double change = value.f / value.slope;
    t -= change;
    // Its square, times a curvature below 1/mm, is what is still missing.
    if (std::abs(change) < kNearlyDone) return t;
    value = torus.At(t);
  }
  return std::numeric_limits<double>::quiet_NaN();
}

FaceRoots MeetTorus(const TorusOnRay& torus, double low, double high, bool starts_here) {
  FaceRoots roots;
  const double length = high - low;
  const double middle = 0.5 * (low + high);
  const TorusOnRay::Value value = torus.At(middle);
  if (std::abs(value.slope) > 0.5 * torus.bending * length) {  // at most one
    if (starts_here) return roots;
    const double t = NewtonFrom(torus, middle, value);
    if (t >= low && t <= high) {
      roots.t[roots.count++] = t;
      return roots;
    }
  }
  Isolate(torus, {low, torus.At(low).f}, {high, torus.At(high).f}, roots);
  return roots;
}

/// The sphere w + c/2·|p|² = 0: c/2·t² + 2·half·t + constant = 0, on the vertex' side of its middle.
FaceRoots MeetSphere(double c, const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) {
  const double square = 0.5 * c;
  const double half = 0.5 * (direction.z() + c * origin.dot(direction));
  const double constant = origin.z() + square * origin.squaredNorm();
  const double discriminant = half * half - square * constant;
  FaceRoots roots;
  if (!(discriminant >= 0.0)) return roots;
  const double q = -(half + std::copysign(std::sqrt(discriminant), half));
  double first = constant / q;  // NaN or infinite: no root
  double second = q / square;
  if (second < first) std::swap(first, second);
  for (const double t : {first, second}) {
    if (std::isfinite(t) && 1.0 + c * (origin.z() + t * direction.z()) > 0.0) roots.t[roots.count++] = t;
  }
  return roots;
}

}  // namespace

LensFace::LensFace(const LensSurface& surface, const LensRegion& region)
    : rotation_(surface.lens_from_surface.linear().transpose()),
      vertex_(surface.lens_from_surface.translation()),
      curvature_u_(surface.curvature_u),
      curvature_v_(surface.curvature_v) {
  constexpr int kRings = 16;
  constexpr int kSpokes = 64;
  constexpr double kBetweenSamples = 1.2;
  if (curvature_u_ == curvature_v_) return;
  for (const double z : {region.z_low, region.z_high}) {
    for (int ring = 0; ring <= kRings; ++ring) {
      for (int spoke = 0; spoke < kSpokes; ++spoke) {
        const double radius = region.radius * ring / kRings;
        const double angle = 2.0 * std::numbers::pi * spoke / kSpokes;
        const Eigen::Vector3d p =
            ToSurface({region.centre.x() + radius * std::cos(angle), region.centre.y() + radius * std::sin(angle), z});
        bending_ = std::max(bending_, kBetweenSamples * BendingAt(curvature_u_, curvature_v_, p.x(), p.y()));
      }
    }
  }
}

bool LensFace::Reaches(const Eigen::Vector3d& on_surface) const {
  const Eigen::Vector3d p = ToSurface(on_surface);
  if (!(std::abs(curvature_u_ * p.x()) < kSteepest)) return false;
  // Q = 1 − b·h, and b²v² = W² − Q².
  const double q = 1.0 + curvature_v_ * p.z();
  const double y = curvature_v_ * p.y();
  return q > 0.0 && std::abs(y) < kSteepest * std::sqrt(q * q + y * y);
}

double LensFace::Before(const Eigen::Vector3d& p_in_lens) const {
  const Eigen::Vector3d p = ToSurface(p_in_lens);
  if (curvature_u_ == curvature_v_) return p.z() + 0.5 * curvature_u_ * p.squaredNorm();
  return p.z() + SagAt(curvature_u_, curvature_v_, p.x(), p.y()).h;
}

Eigen::Vector3d LensFace::Normal(const Eigen::Vector3d& p_in_lens) const {
  const Eigen::Vector3d p = ToSurface(p_in_lens);
  if (curvature_u_ == curvature_v_) {
    return (rotation_.transpose() * (Eigen::Vector3d::UnitZ() + curvature_u_ * p)).normalized();
  }
  const Sag sag = SagAt(curvature_u_, curvature_v_, p.x(), p.y());
  return rotation_.transpose() * Eigen::Vector3d(sag.hu, sag.hv, 1.0).normalized();
}

FaceRoots LensFace::Meet(const Stretch& ray) const {
  const Eigen::Vector3d o = ToSurface(ray.origin);
  const Eigen::Vector3d d = rotation_ * ray.direction;
  if (curvature_u_ != curvature_v_) {
    const double across = d.x() * d.x() + d.y() * d.y();
    return MeetTorus({curvature_u_, curvature_v_, o, d, bending_ * across}, ray.low, ray.high, ray.starts_here);
  }
  FaceRoots all = MeetSphere(curvature_u_, o, d);
  FaceRoots within;
  for (std::size_t i = 0; i < all.count; ++i) {
    if (all.t[i] >= ray.low && all.t[i] <= ray.high) within.t[within.count++] = all.t[i];
  }
  return within;
}

}  // namespace annulus
