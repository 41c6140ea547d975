#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "base/progress.h"
#include "base/result.h"
#include "modeling/flatten/flatten.h"
#include "modeling/flatten/pattern.h"
#include "modeling/flatten/pattern_lines.h"
#include "modeling/flatten/pattern_piece.h"

namespace annulus {

/// A piece of a pattern in the plane.
struct FlatPiece {
  std::string id;
  std::string label;
  BodyPiece body;                        ///< On the body, with the same vertices.
  std::vector<Eigen::Vector2d> points;   ///< Per vertex, mm; the grain line runs along +y.
  std::vector<Eigen::Vector3d> strains;  ///< Per face: weft, warp, shear angle.
  std::vector<std::uint32_t> rim;        ///< Counter-clockwise, the right side of the cloth up.
  double energy = 0.0;                   ///< N·mm
  double body_area_mm2 = 0.0;
  double flat_area_mm2 = 0.0;
  double largest_strain = 0.0;  ///< Of the principal strains, by amount.
  double strain_98 = 0.0;       ///< Exceeded on 2 % of the area.
};

/// How long the two sides of a seam are.
struct FlatSeam {
  std::string line;  ///< Of the pattern (whose parts may be several seams), or "PIECE dart N", "PIECE division N".
  std::array<std::size_t, 2> piece{};  ///< Their numbers; twice the same for darts.
  double body_mm = 0.0;                ///< On the body.
  std::array<double, 2> flat_mm{};
};

/// A pattern laid flat on one body.
struct FlatPattern {
  std::string name;
  std::vector<FlatPiece> pieces;
  std::vector<FlatSeam> seams;
  double energy = 0.0;
  int steps = 0;
};

/// Flattens all pieces of a pattern together, so that the two sides of every seam and the legs of every dart are
/// equally long, element by element (within 1e-5 mm each). Fails as SampleLines, CutPiece and Flatten; if more than two
/// sides meet in a line; if Newton's method does not converge; and if a piece would overlap itself, naming it.
[[nodiscard]] Result<FlatPattern> FlattenPattern(const Pattern& pattern, const PatternBody& body,
                                                 const TaskContext& task);

/// The same for pieces that are cut out already, along the pattern's sampled lines.
[[nodiscard]] Result<FlatPattern> LayFlat(const Pattern& pattern, std::vector<BodyPiece> bodies,
                                          const std::vector<SampledLine>& lines);

/// A mesh with one rim as a pattern of one piece without lines; the material is the pattern's. Darts are proposed by
/// its rule as WithProposedCuts does, along sides of the triangles. Fails as LayFlat.
[[nodiscard]] Result<FlatPattern> FlattenMesh(const TriangleMesh& mesh, const Pattern& pattern,
                                              const TaskContext& task);

/// The pattern with darts and divisions added by its rule: while the strain of a piece exceeds the bound on more than
/// 2 % of its area, first darts, as long as their count allows: a cut to the place of greatest angle defect (curvature
/// gathered within a tenth of the piece), from that one of the rim's places whose cut relieves most energy. Only cuts
/// that open count: saddles cannot be relieved by darts. Where none is left that does, and the count allows, a
/// division: from rim to rim through the place where most curvature of either sign is gathered, well away from the rim,
/// between those of the rim's places that leave the least energy and bend it there by no more than 60 degrees.
[[nodiscard]] Result<Pattern> WithProposedCuts(const Pattern& pattern, const PatternBody& body,
                                               const TaskContext& task);

}  // namespace annulus
