#pragma once

#include <Eigen/SparseCore>
#include <memory>

#include "fitting/hierarchical_spline.h"
#include "fitting/surface_model.h"

namespace annulus {

/// T with active coefficients of `to` = T · active coefficients of `from`, of two splines on the same coarsest grid. A
/// function that both have keeps its coefficient (Giannelli, Jüttler, Speleers 2014: truncation preserves
/// coefficients); another's is read off the polynomial on a cell of `to`, exact where that cell lies in one of `from`.
/// So if `finer` splits cells of `coarser` and no others, CoefficientTransfer(coarser, finer) is the refinement, and
/// CoefficientTransfer(finer, coarser) undoes it.
[[nodiscard]] Eigen::SparseMatrix<double> CoefficientTransfer(const HierarchicalSpline& from,
                                                              const HierarchicalSpline& to);

/// The same surface on a spline that splits cells of the segment's own and no others. Without a normal matrix; a
/// surface P(u, v) becomes its tensor form.
[[nodiscard]] SurfaceSegment Refined(const SurfaceSegment& segment, std::shared_ptr<const HierarchicalSpline> finer);

/// A normal matrix (upper triangle) of the refined coefficients under which any quantity has the variance that it had:
/// what the refinement added is held, at 3e-3 of the smallest sd, to what the old coefficients say. To be made in one
/// step from the surface as it was fitted: each step widens the range of its numbers. Without entries if it would have
/// too many: where large parts are much finer.
[[nodiscard]] Eigen::SparseMatrix<double> RefinedPrecision(const Eigen::SparseMatrix<double>& upper,
                                                           const HierarchicalSpline& coarser,
                                                           const HierarchicalSpline& finer);

/// The segment's surface as a hierarchical spline; of one level where it has none.
struct ControlledSurface {
  std::shared_ptr<const HierarchicalSpline> spline;
  Eigen::VectorXd active;
};
[[nodiscard]] ControlledSurface ControlledBy(const SurfaceSegment& segment);

}  // namespace annulus
