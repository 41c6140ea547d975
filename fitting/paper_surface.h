#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <vector>

#include "base/result.h"
#include "fitting/spline_surface.h"

namespace annulus {

/// Control points V of the closed uniform cubic B-spline curve through the rows of `points` (paper 001, eq. 2.8).
/// Requires at least 3 rows.
[[nodiscard]] Eigen::MatrixXd ClosedControlPoints(const Eigen::MatrixXd& points);

/// Control points Q of the open one through the rows, with Q_0 = Q_1 and Q_n = Q_{n-1} (eq. 2.11): two rows more than
/// `points`; the first point belongs to Q_0 … Q_2. The end rule makes P'' at the ends parallel to P', so the curvature
/// there is 0 though P'' is not. Requires at least 2 rows.
[[nodiscard]] Eigen::MatrixXd OpenControlPoints(const Eigen::MatrixXd& points);

/// P_i of a section (eq. 2.7): x and y, mm, in columns, of the points at radius r_i, mm, in direction theta_i, rad.
[[nodiscard]] Eigen::MatrixXd SectionPoints(const std::vector<double>& theta, const Eigen::VectorXd& radius);

/// Whether the closed curve of these control points (x, y in columns; eq. 2.9) somewhere does not run counter-clockwise
/// about the origin. Checked at 8 places of every span.
[[nodiscard]] bool TurnsBack(const Eigen::MatrixXd& control);

/// A point of the surface and its partial derivatives, mm.
struct SurfacePartials {
  Eigen::Vector3d point = Eigen::Vector3d::Zero();
  Eigen::Vector3d u = Eigen::Vector3d::Zero();
  Eigen::Vector3d v = Eigen::Vector3d::Zero();
  Eigen::Vector3d uu = Eigen::Vector3d::Zero();
  Eigen::Vector3d uv = Eigen::Vector3d::Zero();
  Eigen::Vector3d vv = Eigen::Vector3d::Zero();
};

/// Parameters of a place on the surface.
struct SurfaceParameters {
  double u = 0.0;  ///< [0, theta knots); u = i on the knot line theta_i.
  double v = 0.0;  ///< [0, z knots - 1]; v = j on the knot line z_j.
};

/// The bicubic uniform B-spline surface P(u, v) of paper 001, eqs. 2.10 and 2.11: closed in u, open in v with
/// Q_{i,0} = Q_{i,1} and Q_{i,n} = Q_{i,n-1}. Station frame, mm. z depends on v alone and rises; every section is a
/// star about the axis, so that (theta, z) has one (u, v). Immutable value.
class PaperSurface {
 public:
  /// `control` holds Q_{i,j} at j·theta_knots.size() + i, for j = 0 … z_knots.size() + 1. theta_knots (rad) rise within
  /// one turn, z_knots (mm) rise; at least 4 and 2. Fails, and says where, if numbers are not finite or beyond 10 m
  /// (theta: 2 turns; z: 100 m), the end rule is broken, z is not the same along u or does not rise, knot line i is not
  /// at theta_i, or a section turns back on itself (checked at 8 × 8 places of every patch).
  static Result<PaperSurface> FromControlPoints(std::vector<double> theta_knots, std::vector<double> z_knots,
                                                std::vector<Eigen::Vector3d> control);

  /// The surface through P_ij = (r_ij cos theta_i, r_ij sin theta_i, z_j) (eq. 2.13): eq. 2.8 for every section, then
  /// eq. 2.11. `radius` holds r_ij, mm, in row j and column i. Fails as FromControlPoints.
  static Result<PaperSurface> Through(std::vector<double> theta_knots, std::vector<double> z_knots,
                                      const Eigen::MatrixXd& radius);

  [[nodiscard]] const std::vector<double>& theta_knots() const { return theta_knots_; }
  [[nodiscard]] const std::vector<double>& z_knots() const { return z_knots_; }
  [[nodiscard]] const std::vector<Eigen::Vector3d>& control() const { return control_; }
  [[nodiscard]] double z_min() const { return z_knots_.front(); }
  [[nodiscard]] double z_max() const { return z_knots_.back(); }

  /// P(u, v) and its derivatives (eq. 2.10). u is taken modulo its period, v into its range.
  [[nodiscard]] SurfacePartials Partials(const SurfaceParameters& at) const;
  [[nodiscard]] Eigen::Vector3d PointAt(const SurfaceParameters& at) const { return Partials(at).point; }

  /// The (u, v) of a place: v from z, then u such that P lies in direction theta within 1e-12 rad, by Newton's method
  /// kept inside a bracket. Any finite theta, rad; z, mm, is taken into [z_min, z_max].
  [[nodiscard]] SurfaceParameters Solve(double theta, double z) const;
  /// r(theta, z) and its derivatives through the implicit function (u, v)(theta, z).
  [[nodiscard]] RadiusJet Jet(double theta, double z) const;
  [[nodiscard]] double Radius(double theta, double z) const;
  /// The point in the station frame, mm.
  [[nodiscard]] Eigen::Vector3d Point(double theta, double z) const;
  /// The outward unit normal, station frame.
  [[nodiscard]] Eigen::Vector3d Normal(double theta, double z) const;

  /// Control points V of the section at height z (eq. 2.9), in the plane, mm; z is taken into its range.
  [[nodiscard]] std::vector<Eigen::Vector2d> SectionControlPoints(double z) const;
  /// Control points of the longitudinal section along the knot line nearest to theta: (r, z), mm.
  [[nodiscard]] std::vector<Eigen::Vector2d> MeridianControlPoints(double theta) const;

 private:
  PaperSurface(std::vector<double> theta_knots, std::vector<double> z_knots, std::vector<Eigen::Vector3d> control);
  [[nodiscard]] Status CheckSections() const;
  [[nodiscard]] double SolveV(double z) const;
  /// The four control points, in the plane, of one span of the section at v.
  [[nodiscard]] std::array<Eigen::Vector2d, 4> SectionSpan(std::size_t span, double v) const;

  std::vector<double> theta_knots_;
  std::vector<double> z_knots_;
  std::vector<Eigen::Vector3d> control_;
};

/// The same surface as r(theta, z) on a regular tensor grid, for what needs one (meshes, gradients of measures): its
/// surface, and how far it is from the other.
struct TensorApproximation {
  SplineSurface surface;
  double largest_error = 0.0;  ///< mm, along the normal, half-way between grid lines; of up to 2^16 places.
};

/// Doubles the grid until the largest error is at most 0.01 mm or the grid has 2^19 coefficients (where a section runs
/// nearly towards the axis, r(theta) is too steep for any grid). Deterministic.
[[nodiscard]] TensorApproximation ApproximateByTensor(const PaperSurface& surface);

}  // namespace annulus
