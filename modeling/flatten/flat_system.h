#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <optional>
#include <vector>

#include "modeling/flatten/flatten.h"

namespace annulus {

/// The energy of a flat sheet with its seams, and Newton's steps on it. Held: of every part the first grain vertex and
/// the x of the second, which takes out the rigid motions and sets the grain line upright. Borrows the sheet.
class FlatSystem {
 public:
  using Points = std::vector<Eigen::Vector2d>;

  /// Requires a checked sheet and one grain pair per part.
  FlatSystem(const CurvedSheet& sheet, const FlattenOptions& options, const std::vector<GrainPair>& grain);

  [[nodiscard]] const std::vector<FlatElement>& elements() const { return elements_; }
  /// Elastic energy alone, N·mm.
  [[nodiscard]] double Elastic(const Points& flat) const;
  /// With the seams' terms.
  [[nodiscard]] double Total(const Points& flat) const;
  /// Largest difference of two sewn sides, mm.
  [[nodiscard]] double SeamGap(const Points& flat) const;
  /// Moves the seams' multipliers to where the present differences would vanish.
  void UpdateMultipliers(const Points& flat);

  struct Step {
    Points move;
    double slope = 0.0;  ///< Of the total energy along it, <= 0.
  };
  /// Newton's step: by the exact curvature where that has a minimum, else by its convex part. Nothing if the equations
  /// cannot be solved.
  [[nodiscard]] std::optional<Step> Newton(const Points& flat);
  /// The largest part of a move, <= 1, that turns no triangle over.
  [[nodiscard]] double LargestPart(const Points& flat, const Points& move) const;

 private:
  using Sparse = Eigen::SparseMatrix<double>;
  using Curvature = FlatElement::Curvature;

  void Assemble(const Points& flat, Curvature curvature);
  void AssembleSeams(const Points& flat, Curvature curvature);
  void AddSeam(std::size_t seam, const Points& flat, Curvature curvature);
  [[nodiscard]] FlatElement::Corners CornersOf(std::size_t face, const Points& flat) const;
  [[nodiscard]] double Difference(std::size_t seam, const Points& flat) const;

  const CurvedSheet& sheet_;
  std::vector<FlatElement> elements_;
  Eigen::Matrix3d stiffness_;
  std::vector<SewnEdge> sewn_;
  std::vector<double> multiplier_;  ///< N, per seam.
  double seam_rate_;                ///< N/mm
  std::vector<int> unknown_;        ///< Of (vertex, axis); −1: held.
  int count_ = 0;
  std::vector<Eigen::Triplet<double>> entries_;
  Eigen::VectorXd gradient_;
  Sparse matrix_;
  Eigen::SimplicialLLT<Sparse> factor_;
  bool analysed_ = false;
};

}  // namespace annulus
