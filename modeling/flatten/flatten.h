#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "base/result.h"
#include "modeling/flatten/conformal_start.h"
#include "modeling/flatten/curved_sheet.h"
#include "modeling/flatten/flat_material.h"

namespace annulus {

/// Two rim sides that are sewn to each other: they become equally long in the plane. From and to vertex of each.
struct SewnEdge {
  std::array<std::uint32_t, 2> one{};
  std::array<std::uint32_t, 2> other{};
};

struct FlattenOptions {
  FlatMaterial material{};
  std::vector<SewnEdge> sewn{};
  /// Grain lines of parts: upright in the plane, warp along them. A part without one lies as its longest way runs.
  std::vector<GrainPair> grain{};
  int most_steps = 200;             ///< Newton steps in all, >= 1.
  double seam_tolerance_mm = 1e-5;  ///< Largest difference of two sewn sides, > 0.
};

/// A sheet laid flat.
struct FlatShape {
  std::vector<Eigen::Vector2d> points;   ///< Per vertex, mm; each part about its own origin, warp along +y.
  std::vector<Eigen::Vector3d> strains;  ///< Per face: weft, warp, shear angle (flat_element.h).
  SheetTopology topology;
  double start_energy = 0.0;      ///< Of the conformal (or Tutte's) map, N·mm.
  double energy = 0.0;            ///< N·mm
  int steps = 0;                  ///< Newton steps.
  bool converged = false;         ///< The last full step was below 1e-9 of the sheet's size, seams within tolerance.
  bool from_tutte = false;        ///< The conformal map had turned triangles over.
  double seam_gap_mm = 0.0;       ///< Largest difference of two sewn sides.
  std::size_t rim_crossings = 0;  ///< Places where a part's rim crosses itself: the piece would overlap.
};

/// Lays every part of a sheet flat with the least elastic energy (paper 001, §5; Shimada, Tada 1988): linear strain in
/// the element's own frame, isotropic or with threads. Starts from the conformal map, goes on by local-global steps
/// (Liu, Zhang, Xu, Gotsman, Gortler 2008) and ends by Newton's method with line search; sewn sides are held by
/// multipliers (augmented Lagrangian). No triangle is ever turned over. Fails on a sheet that CheckSheet refuses, a
/// material without positive energy, or grain and sewn vertices that are not there.
[[nodiscard]] Result<FlatShape> Flatten(const CurvedSheet& sheet, const FlattenOptions& options);

/// How often the closed chains `rims` cross themselves (chains of different parts may lie on each other).
[[nodiscard]] std::size_t CountRimCrossings(const std::vector<std::vector<std::uint32_t>>& rims,
                                            const std::vector<Eigen::Vector2d>& flat);

}  // namespace annulus
