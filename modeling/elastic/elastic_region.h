#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "base/result.h"
#include "fitting/surface_model.h"
#include "modeling/elastic/elastic_solver.h"

namespace annulus {

/// Which part of a segment is soft, and how finely it is divided.
struct RegionRequest {
  double theta_from = 0.0;               ///< rad
  double theta_to = 6.2831853071795865;  ///< rad, > theta_from; a turn or more: all around.
  double z_min = 0.0;                    ///< mm
  double z_max = 0.0;                    ///< mm
  double thickness = 20.0;               ///< mm, of the soft layer.
  double spacing = 8.0;                  ///< mm between nodes on the skin, about; 1 … 100.
  std::size_t layers = 3;                ///< Nodes over each other, core and skin included, 2 … 9.
};

/// A part of a measured surface as a soft layer over a firm core: nodes on the skin at equal steps of theta and z, the
/// others below them, down to an inner surface that is held. The rim is held, too.
struct ElasticRegion {
  RegionRequest request;
  SolidGrid grid;
  std::vector<double> theta;            ///< By column, rad, rising; theta.front() may be any angle.
  std::vector<double> z;                ///< By row, mm.
  std::vector<Eigen::Vector3d> normal;  ///< Of the skin, outward, by stack.
  std::vector<double> area;             ///< Of the skin that a stack stands for, mm², by stack.
  std::vector<char> held;               ///< As ElasticProblem::held.
  std::size_t sweeps = 0;  ///< How often the normals were averaged with their neighbours', so that depths do not cross.

  [[nodiscard]] std::size_t SkinNode(std::size_t stack) const {
    return stack * grid.shape.layers + grid.shape.layers - 1;
  }
  [[nodiscard]] bool OnRim(std::size_t stack) const;
};

/// Divides a part of a segment. Fails on numbers out of range, a part outside the segment, more than 200,000 nodes, or
/// a layer that is too thick for the shape.
[[nodiscard]] Result<ElasticRegion> MakeElasticRegion(const SurfaceSegment& segment, const RegionRequest& request);

/// The outward unit normal of a segment, station frame.
[[nodiscard]] Eigen::Vector3d SegmentNormal(const SurfaceSegment& segment, double theta, double z);

/// ∬ r²/2 dθ dz, mm³, exactly: four Gauss nodes each way in every cell, r² having degree 6 there.
[[nodiscard]] double SegmentVolume(const SurfaceSegment& segment);

}  // namespace annulus
