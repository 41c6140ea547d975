#include "fitting/paper_surface.h"

#include <Eigen/Geometry>
#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <cstdio>
#include <string>

#include "base/ensure.h"
#include "base/frames.h"

namespace annulus {
namespace {

constexpr std::size_t kMostKnots = 512;
constexpr std::size_t kMostPatches = std::size_t{1} << 16;
constexpr int kChecksPerSpan = 8;
constexpr double kLargestRadius = 1e4;  // mm
constexpr double kLargestHeight = 1e5;  // mm

/// The uniform cubic B-splines on one span, 0 <= t <= 1, for control points k - 1 … k + 2 of span k (eq. 2.9).
struct UniformWeights {
  explicit UniformWeights(double t) {
    const double s = 1.0 - t;
    value = {s * s * s / 6.0, (4.0 - 6.0 * t * t + 3.0 * t * t * t) / 6.0, (4.0 - 6.0 * s * s + 3.0 * s * s * s) / 6.0,
             t * t * t / 6.0};
    first = {-0.5 * s * s, 0.5 * (3.0 * t - 4.0) * t, 0.5 * (4.0 - 3.0 * s) * s, 0.5 * t * t};
    second = {s, 3.0 * t - 2.0, 3.0 * s - 2.0, t};
  }
  std::array<double, 4> value{};
  std::array<double, 4> first{};
  std::array<double, 4> second{};
};

Eigen::MatrixXd SolveTridiagonal(const std::vector<Eigen::Triplet<double>>& entries, const Eigen::MatrixXd& right) {
  Eigen::SparseMatrix<double> matrix(right.rows(), right.rows());
  matrix.setFromTriplets(entries.begin(), entries.end());
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factor(matrix);
  ENSURE(factor.info() == Eigen::Success, "the spline matrix is positive definite");
  Eigen::MatrixXd solution = factor.solve(right);
  solution += factor.solve(right - matrix * solution);  // one refinement: knots are met to rounding
  return solution;
}

std::string Text(double value) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.6g", value);
  return text.data();
}

tl::unexpected<Error> Refuse(const std::string& seen) {
  return Fail("build the surface of control points", seen,
              "use --method adaptive, or a model written by 'annulus fit'");
}

bool RisesWithin(const std::vector<double>& knots, double low, double high) {
  for (std::size_t k = 0; k < knots.size(); ++k) {
    if (!(knots[k] >= low) || !(knots[k] <= high) || (k > 0 && !(knots[k] > knots[k - 1]))) return false;
  }
  return true;
}

/// z components of the control points, one per row.
std::vector<double> Heights(const std::vector<Eigen::Vector3d>& control, std::size_t columns) {
  std::vector<double> z;
  for (std::size_t k = 0; k < control.size(); k += columns) z.push_back(control[k].z());
  return z;
}

/// z and its derivatives at v.
std::array<double, 3> HeightAt(const std::vector<Eigen::Vector3d>& control, std::size_t columns, std::size_t span,
                               double t) {
  const UniformWeights w(t);
  std::array<double, 3> z{};
  for (std::size_t k = 0; k < 4; ++k) {
    const double q = control[(span + k) * columns].z();
    z[0] += w.value[k] * q;
    z[1] += w.first[k] * q;
    z[2] += w.second[k] * q;
  }
  return z;
}

Status CheckHeights(const std::vector<double>& z_knots, const std::vector<double>& heights) {
  const std::size_t n = heights.size();
  if (heights[0] != heights[1] || heights[n - 1] != heights[n - 2]) return Refuse("the ends break Q0 = Q1");
  for (std::size_t j = 0; j + 3 < n; ++j) {
    // The slope over a span is a parabola; its control values on the span bound it from below.
    const double d0 = heights[j + 1] - heights[j];
    const double d1 = heights[j + 2] - heights[j + 1];
    const double d2 = heights[j + 3] - heights[j + 2];
    const double a = 0.5 * (d0 + d1);
    const double b = 0.5 * (d1 + d2);
    const double bend = 0.5 * (d0 - 2.0 * d1 + d2);
    double lowest = std::min(a, b);
    const double vertex = bend > 0.0 ? (d0 - d1) / (2.0 * bend) : -1.0;
    if (vertex > 0.0 && vertex < 1.0) lowest = std::min(lowest, a - bend * vertex * vertex);
    if (!(lowest > 0.0)) return Refuse("z does not rise with v near z = " + Text(z_knots[j]) + " mm");
  }
  for (std::size_t j = 0; j < z_knots.size(); ++j) {
    const double z = (heights[j] + 4.0 * heights[j + 1] + heights[j + 2]) / 6.0;
    if (!(std::abs(z - z_knots[j]) <= 1e-8 * std::max(1.0, std::abs(z)))) {
      return Refuse("knot line " + std::to_string(j) + " is not at z = " + Text(z_knots[j]) + " mm");
    }
  }
  return {};
}

}  // namespace

Eigen::MatrixXd ClosedControlPoints(const Eigen::MatrixXd& points) {
  const auto n = static_cast<int>(points.rows());
  ENSURE(n >= 3, "a closed curve has three points");
  std::vector<Eigen::Triplet<double>> entries;
  for (int k = 0; k < n; ++k) {
    entries.emplace_back(k, k, 2.0 / 3.0);
    entries.emplace_back(k, (k + 1) % n, 1.0 / 6.0);
    entries.emplace_back(k, (k + n - 1) % n, 1.0 / 6.0);
  }
  return SolveTridiagonal(entries, points);
}

Eigen::MatrixXd OpenControlPoints(const Eigen::MatrixXd& points) {
  const auto n = static_cast<int>(points.rows());
  ENSURE(n >= 2, "an open curve has two points");
  std::vector<Eigen::Triplet<double>> entries;
  for (int k = 0; k < n; ++k) {
    const bool end = k == 0 || k == n - 1;
    entries.emplace_back(k, k, end ? 5.0 / 6.0 : 2.0 / 3.0);  // Q_0 = Q_1 put into the first equation
    if (k > 0) entries.emplace_back(k, k - 1, 1.0 / 6.0);
    if (k < n - 1) entries.emplace_back(k, k + 1, 1.0 / 6.0);
  }
  const Eigen::MatrixXd inner = SolveTridiagonal(entries, points);
  Eigen::MatrixXd control(n + 2, points.cols());
  control.middleRows(1, n) = inner;
  control.row(0) = inner.row(0);
  control.row(n + 1) = inner.row(n - 1);
  return control;
}

Eigen::MatrixXd SectionPoints(const std::vector<double>& theta, const Eigen::VectorXd& radius) {
  ENSURE(radius.size() == static_cast<Eigen::Index>(theta.size()), "one radius per direction");
  Eigen::MatrixXd points(radius.size(), 2);
  for (Eigen::Index i = 0; i < radius.size(); ++i) {
    const double angle = theta[static_cast<std::size_t>(i)];
    points.row(i) << radius[i] * std::cos(angle), radius[i] * std::sin(angle);
  }
  return points;
}

bool TurnsBack(const Eigen::MatrixXd& control) {
  const Eigen::Index n = control.rows();
  for (Eigen::Index span = 0; span < n; ++span) {
    for (int k = 0; k < kChecksPerSpan; ++k) {
      const UniformWeights w(static_cast<double>(k) / kChecksPerSpan);
      Eigen::RowVector2d p = Eigen::RowVector2d::Zero();
      Eigen::RowVector2d slope = Eigen::RowVector2d::Zero();
      for (std::size_t a = 0; a < 4; ++a) {
        const Eigen::RowVector2d q = control.row((span + static_cast<Eigen::Index>(a) + n - 1) % n);
        p += w.value[a] * q;
        slope += w.first[a] * q;
      }
      if (!(p.x() * slope.y() - p.y() * slope.x() > 0.0)) return true;
    }
  }
  return false;
}

PaperSurface::PaperSurface(std::vector<double> theta_knots, std::vector<double> z_knots,
                           std::vector<Eigen::Vector3d> control)
    : theta_knots_(std::move(theta_knots)), z_knots_(std::move(z_knots)), control_(std::move(control)) {}

Result<PaperSurface> PaperSurface::FromControlPoints(std::vector<double> theta_knots, std::vector<double> z_knots,
                                                     std::vector<Eigen::Vector3d> control) {
  const std::size_t m = theta_knots.size();
  const std::size_t n = z_knots.size();
  if (m < 4 || n < 2 || m > kMostKnots || n > kMostKnots || m * n > kMostPatches) {
    return Refuse(std::to_string(m) + " x " + std::to_string(n) + " knots");
  }
  if (control.size() != m * (n + 2)) return Refuse(std::to_string(control.size()) + " control points for the knots");
  if (!RisesWithin(theta_knots, -kTwoPi, 2.0 * kTwoPi) || !(theta_knots.back() < theta_knots.front() + kTwoPi) ||
      !RisesWithin(z_knots, -kLargestHeight, kLargestHeight)) {
    return Refuse("knots that do not rise, or not within one turn");
  }
  for (std::size_t k = 0; k < control.size(); ++k) {
    const Eigen::Vector3d& q = control[k];
    if (!q.allFinite() || q.head<2>().norm() > kLargestRadius || std::abs(q.z()) > 2.0 * kLargestHeight) {
      return Refuse("control point " + std::to_string(k) + " is out of range");
    }
    if (q.z() != control[k - k % m].z()) return Refuse("z is not the same along row " + std::to_string(k / m));
    const bool ends_agree =
        k >= m || (q == control[k + m] && control[control.size() - 1 - k] == control[control.size() - 1 - k - m]);
    if (!ends_agree) return Refuse("the ends break Q0 = Q1");
  }
  RETURN_IF_ERROR(CheckHeights(z_knots, Heights(control, m)));
  PaperSurface surface(std::move(theta_knots), std::move(z_knots), std::move(control));
  RETURN_IF_ERROR(surface.CheckSections());
  return surface;
}

Result<PaperSurface> PaperSurface::Through(std::vector<double> theta_knots, std::vector<double> z_knots,
                                           const Eigen::MatrixXd& radius) {
  const auto m = static_cast<Eigen::Index>(theta_knots.size());
  const auto n = static_cast<Eigen::Index>(z_knots.size());
  ENSURE(radius.rows() == n && radius.cols() == m, "one radius per pair of knots");
  if (m < 4 || n < 2 || !radius.allFinite()) return Refuse("too few knots, or radii that are not finite");
  Eigen::MatrixXd section_control(n, 2 * m);  // row j: x of V_0j … V_mj, then y
  for (Eigen::Index j = 0; j < n; ++j) {
    section_control.row(j) = ClosedControlPoints(SectionPoints(theta_knots, radius.row(j))).reshaped().transpose();
  }
  const Eigen::MatrixXd control = OpenControlPoints(section_control);
  const Eigen::MatrixXd heights = OpenControlPoints(Eigen::Map<const Eigen::VectorXd>(z_knots.data(), n));
  std::vector<Eigen::Vector3d> points;
  for (Eigen::Index j = 0; j < control.rows(); ++j) {
    for (Eigen::Index i = 0; i < m; ++i) points.emplace_back(control(j, i), control(j, m + i), heights(j, 0));
  }
  return FromControlPoints(std::move(theta_knots), std::move(z_knots), std::move(points));
}

Status PaperSurface::CheckSections() const {
  constexpr double kSameDirection = 1e-9;  // rad
  const std::size_t m = theta_knots_.size();
  for (std::size_t row = 0; row <= (z_knots_.size() - 1) * kChecksPerSpan; ++row) {
    const double v = static_cast<double>(row) / kChecksPerSpan;
    for (std::size_t column = 0; column < m * kChecksPerSpan; ++column) {
      const SurfacePartials p = Partials({static_cast<double>(column) / kChecksPerSpan, v});
      const double turning = p.point.x() * p.u.y() - p.point.y() * p.u.x();
      const double theta = std::atan2(p.point.y(), p.point.x());
      const bool on_knot = column % kChecksPerSpan == 0;
      const double off = on_knot ? AngleDifference(theta, theta_knots_[column / kChecksPerSpan]) : 0.0;
      if (turning > 0.0 && std::abs(off) <= kSameDirection) continue;
      return Refuse("the section at z = " + Text(p.point.z()) +
                    " mm turns back on itself at theta = " + Text(DegreesFromRadians(WrapAngle(theta))) + " deg");
    }
  }
  return {};
}

SurfacePartials PaperSurface::Partials(const SurfaceParameters& at) const {
  const std::size_t m = theta_knots_.size();
  const auto spans = static_cast<double>(z_knots_.size() - 1);
  const double u = at.u - std::floor(at.u / static_cast<double>(m)) * static_cast<double>(m);
  const double v = std::clamp(at.v, 0.0, spans);
  const std::size_t i = std::min(static_cast<std::size_t>(u), m - 1);
  const std::size_t j = std::min(static_cast<std::size_t>(v), z_knots_.size() - 2);
  const UniformWeights along(u - static_cast<double>(i));
  const UniformWeights up(v - static_cast<double>(j));
  SurfacePartials p;
  for (std::size_t b = 0; b < 4; ++b) {
    Eigen::Vector3d value = Eigen::Vector3d::Zero();
    Eigen::Vector3d first = Eigen::Vector3d::Zero();
    Eigen::Vector3d second = Eigen::Vector3d::Zero();
    for (std::size_t a = 0; a < 4; ++a) {
      const Eigen::Vector3d& q = control_[(j + b) * m + (i + a + m - 1) % m];
      value += along.value[a] * q;
      first += along.first[a] * q;
      second += along.second[a] * q;
    }
    p.point += up.value[b] * value;
    p.u += up.value[b] * first;
    p.uu += up.value[b] * second;
    p.v += up.first[b] * value;
    p.uv += up.first[b] * first;
    p.vv += up.second[b] * value;
  }
  // z depends on v alone: take it from one column, so that nothing of it is left to rounding.
  const std::array<double, 3> z = HeightAt(control_, m, j, v - static_cast<double>(j));
  p.point.z() = z[0];
  p.v.z() = z[1];
  p.vv.z() = z[2];
  p.u.z() = p.uu.z() = p.uv.z() = 0.0;
  return p;
}

double PaperSurface::SolveV(double z) const {
  const double wanted = std::clamp(z, z_min(), z_max());
  const auto above = std::upper_bound(z_knots_.begin() + 1, z_knots_.end() - 1, wanted);
  const auto span = static_cast<std::size_t>(above - z_knots_.begin()) - 1;
  double low = 0.0;
  double high = 1.0;
  double t = (wanted - z_knots_[span]) / (z_knots_[span + 1] - z_knots_[span]);
  for (int k = 0; k < 60; ++k) {
    const std::array<double, 3> height = HeightAt(control_, theta_knots_.size(), span, t);
    const double miss = height[0] - wanted;
    if (miss == 0.0) break;
    (miss > 0.0 ? high : low) = t;
    const double newton = t - miss / height[1];
    const double next = newton > low && newton < high ? newton : 0.5 * (low + high);
    const bool settled = std::abs(next - t) < 1e-15;
    t = next;
    if (settled) break;
  }
  return static_cast<double>(span) + t;
}

SurfaceParameters PaperSurface::Solve(double theta, double z) const {
  const double v = SolveV(z);
  // Knot line i lies at theta_i on every section (eq. 2.7), so the knots bracket u.
  const std::size_t m = theta_knots_.size();
  const double wanted = theta_knots_.front() + WrapAngle(theta - theta_knots_.front());
  const auto above = std::upper_bound(theta_knots_.begin() + 1, theta_knots_.end(), wanted);
  const auto span = static_cast<std::size_t>(above - theta_knots_.begin()) - 1;
  const double from = theta_knots_[span];
  const double to = span + 1 < m ? theta_knots_[span + 1] : theta_knots_.front() + kTwoPi;
  const std::array<Eigen::Vector2d, 4> curve = SectionSpan(span, v);
  const Eigen::Vector2d direction(std::cos(theta), std::sin(theta));
  double low = 0.0;
  double high = 1.0;
  double t = (wanted - from) / (to - from);
  for (int k = 0; k < 60; ++k) {
    const UniformWeights w(t);
    Eigen::Vector2d p = Eigen::Vector2d::Zero();
    Eigen::Vector2d slope = Eigen::Vector2d::Zero();
    for (std::size_t a = 0; a < 4; ++a) {
      p += w.value[a] * curve[a];
      slope += w.first[a] * curve[a];
    }
    const double across = direction.x() * p.y() - direction.y() * p.x();
    const double off = std::atan2(across, direction.dot(p));
    if (off == 0.0) break;
    (off > 0.0 ? high : low) = t;
    const double turning = (p.x() * slope.y() - p.y() * slope.x()) / p.squaredNorm();
    const double newton = t - off / turning;
    const double next = newton > low && newton < high ? newton : 0.5 * (low + high);
    const bool settled = std::abs(next - t) * turning < 1e-15;
    t = next;
    if (settled) break;
  }
  const double u = static_cast<double>(span) + t;
  return {u < static_cast<double>(m) ? u : 0.0, v};
}

std::array<Eigen::Vector2d, 4> PaperSurface::SectionSpan(std::size_t span, double v) const {
  const std::size_t m = theta_knots_.size();
  const std::size_t j = std::min(static_cast<std::size_t>(v), z_knots_.size() - 2);
  const UniformWeights up(v - static_cast<double>(j));
  std::array<Eigen::Vector2d, 4> curve;
  for (std::size_t a = 0; a < 4; ++a) {
    curve[a] = Eigen::Vector2d::Zero();
    for (std::size_t b = 0; b < 4; ++b) {
      curve[a] += up.value[b] * control_[(j + b) * m + (span + a + m - 1) % m].head<2>();
    }
  }
  return curve;
}

std::vector<Eigen::Vector2d> PaperSurface::SectionControlPoints(double z) const {
  const double v = SolveV(z);
  std::vector<Eigen::Vector2d> points;
  for (std::size_t span = 0; span < theta_knots_.size(); ++span) points.push_back(SectionSpan(span, v)[1]);
  return points;
}

std::vector<Eigen::Vector2d> PaperSurface::MeridianControlPoints(double theta) const {
  const std::size_t m = theta_knots_.size();
  std::size_t i = 0;
  for (std::size_t k = 1; k < m; ++k) {
    if (std::abs(AngleDifference(theta_knots_[k], theta)) < std::abs(AngleDifference(theta_knots_[i], theta))) i = k;
  }
  const Eigen::Vector2d direction(std::cos(theta_knots_[i]), std::sin(theta_knots_[i]));
  std::vector<Eigen::Vector2d> points;
  for (std::size_t row = 0; row < control_.size(); row += m) {
    const Eigen::Vector3d w =
        (control_[row + (i + m - 1) % m] + 4.0 * control_[row + i] + control_[row + (i + 1) % m]) / 6.0;
    points.emplace_back(direction.dot(w.head<2>()), w.z());
  }
  return points;
}

RadiusJet PaperSurface::Jet(double theta, double z) const {
  using Complex = std::complex<double>;
  const SurfacePartials p = Partials(Solve(theta, z));
  const auto plane = [](const Eigen::Vector3d& d) { return Complex(d.x(), d.y()); };
  // With L = ln(x + iy) = ln r + i·theta, the derivatives of r and theta are those of its two parts.
  const Complex w = plane(p.point);
  const Complex lu = plane(p.u) / w;
  const Complex lv = plane(p.v) / w;
  const Complex luu = plane(p.uu) / w - lu * lu;
  const Complex luv = plane(p.uv) / w - lu * lv;
  const Complex lvv = plane(p.vv) / w - lv * lv;
  const double r = std::abs(w);
  const double ru = r * lu.real();
  const double rv = r * lv.real();
  const double ruu = r * (luu.real() + lu.real() * lu.real());
  const double ruv = r * (luv.real() + lu.real() * lv.real());
  const double rvv = r * (lvv.real() + lv.real() * lv.real());
  const double zv = p.v.z();
  RadiusJet jet;
  jet.r = r;
  jet.r_theta = ru / lu.imag();
  jet.r_z = (rv - jet.r_theta * lv.imag()) / zv;
  jet.r_theta_theta = (ruu - jet.r_theta * luu.imag()) / (lu.imag() * lu.imag());
  jet.r_theta_z = ((ruv - jet.r_theta * luv.imag()) / lu.imag() - jet.r_theta_theta * lv.imag()) / zv;
  // r_z = (r_v - r_theta·theta_v)/z_v, differentiated along constant theta.
  const double r_theta_by_v = zv * jet.r_theta_z + lv.imag() * jet.r_theta_theta;
  const double r_z_by_v = (rvv - r_theta_by_v * lv.imag() - jet.r_theta * lvv.imag()) / zv - jet.r_z * p.vv.z() / zv;
  jet.r_z_z = (r_z_by_v - lv.imag() * jet.r_theta_z) / zv;
  return jet;
}

double PaperSurface::Radius(double theta, double z) const { return PointAt(Solve(theta, z)).head<2>().norm(); }

Eigen::Vector3d PaperSurface::Point(double theta, double z) const { return PointAt(Solve(theta, z)); }

Eigen::Vector3d PaperSurface::Normal(double theta, double z) const {
  const SurfacePartials p = Partials(Solve(theta, z));
  return p.u.cross(p.v).normalized();
}

}  // namespace annulus
