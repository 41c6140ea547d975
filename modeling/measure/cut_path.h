#pragma once

#include <Eigen/Core>
#include <vector>

#include "modeling/measure/cut_curve.h"

namespace annulus {

/// A way over the surface in a clicked plane. The curve borrows the body's surface.
struct CutPath {
  ClickedPlane clicked;
  CutCurve curve;
  std::vector<CutNode> nodes;  ///< In walking order, first and last being the clicked places.
};

/// The way from one click to another through a third, in their plane (paper 001, §3.1 (1)): of the closed curve's two
/// ways the one that passes `via`. Fails like ClickedPlane::Through, and if the curve leaves the scanned range, closes
/// without passing all three, or touches the plane without crossing.
[[nodiscard]] Result<CutPath> CutThrough(const MeasuredSurface& body, const Click& from, const Click& via,
                                         const Click& to);

/// The way from one click to another that a viewer sees as their straight connection (paper 001, §3.3 (2)), looking
/// along `view` (from the viewer towards the body; any length). Of the two ways around, the one that lies nearer to the
/// viewer in the mean; if only one stays on the scanned surface, that one. Fails like ClickedPlane::InView, and if
/// neither way reaches the other click.
[[nodiscard]] Result<CutPath> CutInView(const MeasuredSurface& body, const Click& from, const Click& to,
                                        const Eigen::Vector3d& view);

/// The polygon through points of a clicked plane's cut, first and last being clicked places that move with their
/// radius: its length, mm, and how it follows the surface, along the way and by the plane, which follows its clicks.
[[nodiscard]] Estimate ClickedLength(const SplineSurface& surface, const ClickedPlane& clicked,
                                     const std::vector<PathPoint>& points);

/// Says why a walk did not get to `goal`.
[[nodiscard]] Error WalkError(const CutWalk& walk, const std::string& goal, const std::string& attempted);

}  // namespace annulus
