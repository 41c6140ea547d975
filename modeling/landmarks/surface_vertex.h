#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "fitting/spline_surface.h"
#include "modeling/measure/estimate.h"
#include "modeling/measure/measured_surface.h"

namespace annulus {

/// One part of a field: the surface near a place, weighted.
struct FieldTerm {
  double d_theta = 0.0;  ///< rad, from the place at which the field is taken.
  double d_z = 0.0;      ///< mm
  double weight = 1.0;
};

/// A field over the surface, mm: at (theta, z) the sum of weight · g(theta + d_theta, z + d_z) over the terms. g is the
/// radius, or how far the surface's point lies along a direction. Linear in the surface.
class SurfaceField {
 public:
  /// The distance from the ring's axis. It moves with the subject's place in the ring; prefer Along for landmarks.
  static SurfaceField Radius();
  /// p · direction, station frame. `direction` is made a unit vector; it must not be zero.
  static SurfaceField Along(const Eigen::Vector3d& direction);

  /// How far this field stands above the middle of its values `d_theta` rad and `d_z` mm before and behind: the height
  /// over a chord, positive on a bulge, negative in a hollow.
  [[nodiscard]] SurfaceField OverChord(double d_theta, double d_z) const;

  /// How much this field falls from `d_theta` rad and `d_z` mm before the place to as far behind it.
  [[nodiscard]] SurfaceField Fall(double d_theta, double d_z) const;

  [[nodiscard]] const std::vector<FieldTerm>& terms() const { return terms_; }
  /// The value at a place, mm; d_z beyond the surface's ends is taken at the end.
  [[nodiscard]] double At(const SplineSurface& surface, const SurfacePlace& place) const;
  /// g and its derivatives as factors of a radius jet: g = radial(theta) · r + upward · z.
  [[nodiscard]] double radial(double theta) const;
  /// d(radial)/d(theta).
  [[nodiscard]] double radial_theta(double theta) const;
  [[nodiscard]] double upward() const { return along_ ? along_->z() : 0.0; }

 private:
  std::optional<Eigen::Vector3d> along_;  // empty: the radius
  std::vector<FieldTerm> terms_{{0.0, 0.0, 1.0}};
};

/// How the field runs about a vertex.
enum class VertexShape {
  kSummit,       ///< Largest in all directions.
  kHollow,       ///< Smallest in all directions.
  kRidgeHollow,  ///< Largest across (along theta), smallest along z: the nose's root.
  kRidgeBulge,   ///< Smallest across, largest along z.
};

/// Which coordinates of the place are sought; the other one stays at the start's.
enum class VertexFreedom { kBoth, kAcross, kUp };

/// What is sought, and over which window.
struct VertexQuery {
  SurfaceField field;
  VertexShape shape = VertexShape::kSummit;
  VertexFreedom freedom = VertexFreedom::kBoth;
  double half_across = 8.0;  ///< mm along the horizontal circle through the vertex, > 0.
  double half_up = 8.0;      ///< mm, > 0.
};

/// Vertex of a field, and how clearly it shows.
struct SurfaceVertex {
  Estimate theta;            ///< rad, in the start's turn.
  Estimate z;                ///< mm
  double height = 0.0;       ///< mm; the paraboloid's value at its vertex.
  double rise_across = 0.0;  ///< mm; how much the paraboloid changes from the window's middle to its side.
  double rise_up = 0.0;      ///< mm; and to its upper and lower edge. Negative at a summit.
  double residual = 0.0;     ///< mm, rms of the field about the paraboloid.
  /// 0 … 1: s / (s + residual + 0.5 mm) with s the smaller |rise| of the sought coordinates.
  double confidence = 0.0;
};

/// The extremum of a field, defined so that noise hardly moves it: the place at which the paraboloid, fitted by least
/// squares to the field over a window about that place (weights (1 − u²)(1 − v²), falling to nothing at the window's
/// edge), has its vertex. Searched from `start`, where any step stays within half a window. theta and z carry exact
/// gradients, by implicit differentiation of that condition, re-centring included. Null if the vertex has another shape
/// than asked for, wanders farther than three windows, or if its window leaves the surface's heights.
[[nodiscard]] std::optional<SurfaceVertex> FindVertex(const SplineSurface& surface, const SurfacePlace& start,
                                                      const VertexQuery& query);

/// The same with one coordinate given as an Estimate and the other one sought (freedom kUp: theta is given; kAcross: z
/// is given): the vertex's gradients follow the given one.
[[nodiscard]] std::optional<SurfaceVertex> FindVertexAlong(const SplineSurface& surface, const Estimate& theta,
                                                           const Estimate& z, const VertexQuery& query);

}  // namespace annulus
