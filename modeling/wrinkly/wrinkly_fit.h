#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <span>
#include <vector>

#include "base/progress.h"
#include "base/result.h"
#include "modeling/wrinkly/wrinkly_surface.h"

namespace annulus {

/// A value that a wrinkly surface is to have somewhere.
struct WrinklyTarget {
  PointIndex patch = 0;
  double u = 0.5;  ///< 0 … 1
  double v = 0.5;
  double value = 0.0;
  double weight = 1.0;  ///< > 0
};

/// Control values that a fit found.
struct WrinklyFit {
  Eigen::VectorXd values;          ///< One per control point; of those that no target draws on, the mean of the others.
  std::vector<char> is_seen;       ///< Whether any target draws on the control point.
  double rms = 0.0;                ///< Of target less surface, weighted.
  double rms_before = 0.0;         ///< The same about the mean of the targets.
  std::size_t points_without = 0;  ///< Control points of patches that no target draws on.
};

/// Finds the control points' values of one attribute so that, with `iterations` iterations (whole), the surface has the
/// targets' values as well as it can: linear least squares, since eq. 12 is linear in them. The surface's own values do
/// not matter, its mesh, crossings and α do. Fails on no target, a target outside its patch, or a stop request.
[[nodiscard]] Result<WrinklyFit> FitWrinklyValues(const WrinklySurface& surface, int iterations,
                                                  std::span<const WrinklyTarget> targets, const TaskContext& task);

/// The control mesh whose base surface goes through `middles` in the middles of its patches (control points without a
/// patch stay): places are moved until none is off by more than 1e-9 of the size. Requires one middle per point. Fails
/// as ControlMesh::Make with FamilyRule::kCut.
[[nodiscard]] Result<ControlMeshParts> ThroughMiddles(ControlMeshParts parts, std::span<const Eigen::Vector3d> middles);

}  // namespace annulus
