#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <map>
#include <vector>

#include "modeling/clay/clay_body.h"

namespace annulus {

/// A piece of a leaf's section by a level plane, from one grid line of the leaf to the next.
struct SectionPiece {
  Eigen::Vector3d from, to;
  double length_mm = 0.0;  ///< Along the surface.
};

/// Girths of a body that is being shaped, at given heights, kept up to date by computing anew only the leaves that
/// changed. Borrows nothing; Follow has to be given the same body, or a copy, each time.
class ClayGirths {
 public:
  /// `levels`: z in mm.
  ClayGirths(const ClayBody& body, std::vector<double> levels);
  void Follow(const ClayBody& body);

  [[nodiscard]] const std::vector<double>& levels() const { return levels_; }
  /// Length of the section at a level, all its loops together, mm; to about 1e-6 of it for leaves that bend by less
  /// than 30°. 0 where nothing is.
  [[nodiscard]] double Perimeter(std::size_t level) const { return sections_.at(level).perimeter; }
  /// Length of a tape around the section: its convex hull, mm.
  [[nodiscard]] double Tape(std::size_t level) const { return sections_.at(level).tape; }

 private:
  struct Section {
    std::map<PatchIndex, std::vector<SectionPiece>> pieces;  ///< Of the leaves that it cuts.
    double perimeter = 0.0;
    double tape = 0.0;
    bool changed = true;  ///< The lengths are those of other pieces.
  };
  void Renew(const ClayBody& body, PatchIndex leaf);
  void Measure();

  std::vector<double> levels_;
  std::size_t seen_ = 0;
  std::vector<Section> sections_;  ///< By level.
};

/// Where the plane z = `level` cuts a patch, on a grid of 6 × 6 cells of its parameters.
[[nodiscard]] std::vector<SectionPiece> SectionOf(const BezierPatch::ControlNet& net, double level);

}  // namespace annulus
