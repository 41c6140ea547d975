#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <vector>

#include "modeling/measure/estimate.h"
#include "modeling/measure/gauss.h"
#include "modeling/measure/measured_surface.h"

namespace annulus {

/// Integrals over parts of the (theta, z) plane of a surface, with their derivatives by its coefficients:
///   skin    ∬ |P_theta × P_z|
///   volume  ∬ (1/3)(P - apex) · (P_theta × P_z), the flux of a field of divergence 1 that runs along every plane
///           through the apex; for its derivative the movement of the skin counts: ∬ r·∂r.
/// Strips are the rows of knot intervals in z; all rules have 4 Gauss points per knot interval or piece of one, exact
/// for polynomials of degree 7. Borrows the surface. Thread-bound.
class RegionQuadrature {
 public:
  RegionQuadrature(const SplineSurface& surface, const Eigen::Vector3d& apex);

  /// Adds the part of a strip between two angles, rad, not wrapped, from < to.
  void AddRectangle(std::size_t strip, double from, double to);
  /// Adds weight · ∫ dz from the strip's lower edge to z at one theta (both integrands); z may lie a little outside.
  void AddColumn(std::size_t strip, const SurfacePlace& top, double weight);
  /// Adds weight · r to derivatives of the skin, for the boundary's own movement.
  void AddSkinByRadius(const SurfacePlace& place, double weight);
  /// |P_theta × P_z| at a place, mm²/rad/mm.
  [[nodiscard]] double SkinDensity(const SurfacePlace& place) const;

  [[nodiscard]] double skin() const { return skin_; }
  [[nodiscard]] double volume() const { return volume_; }
  [[nodiscard]] Gradient SkinGradient() const;
  [[nodiscard]] Gradient VolumeGradient() const;

 private:
  /// What depends on theta only, at one node.
  struct ThetaNode {
    double theta = 0.0;
    double weight = 0.0;
    double apex_outward = 0.0;  // apex · e_r
    double apex_around = 0.0;   // apex · e_theta
    std::array<double, 4> value{};
    std::array<double, 4> first{};
  };
  struct ZNode {
    double z = 0.0;
    double weight = 0.0;
    std::array<double, 4> value{};  // of z-splines strip … strip + 3
    std::array<double, 4> first{};
  };
  struct Densities {
    double skin = 0.0;
    double skin_by_r = 0.0;
    double skin_by_theta = 0.0;  // by r_theta
    double skin_by_z = 0.0;      // by r_z
    double volume = 0.0;
  };
  /// A strip between columns: sums over z of the splines at its four heights, by theta-spline, and the derivatives of
  /// the integrals by them.
  struct StripRow {
    std::array<Eigen::VectorXd, 4> radius, slope, skin_by_radius, skin_by_slope, volume_by_radius;
  };

  [[nodiscard]] ThetaNode NodeAt(long cell, double theta, double weight) const;
  [[nodiscard]] std::array<ZNode, 4> HeightsIn(std::size_t strip, double top) const;
  [[nodiscard]] Densities At(const ThetaNode& node, double z, double r, double r_theta, double r_z) const;
  void AddNodes(const std::array<ThetaNode, 4>& across, const std::array<ZNode, 4>& up, Eigen::Index column,
                StripRow& row);
  void AddRow(std::size_t strip, const std::array<ZNode, 4>& up, long first_cell, const StripRow& row);
  [[nodiscard]] std::size_t Column(long spline) const;

  const SplineSurface* surface_;
  Eigen::Vector3d apex_;
  std::vector<QuadratureNode> unit_;
  std::vector<IntervalCubics> cubics_;  // by strip
  std::vector<ThetaNode> whole_;        // four per knot interval in theta
  double skin_ = 0.0;
  double volume_ = 0.0;
  Eigen::VectorXd by_skin_;
  Eigen::VectorXd by_volume_;
};

}  // namespace annulus
