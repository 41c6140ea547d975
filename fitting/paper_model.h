#pragma once

#include <cstddef>
#include <vector>

#include "fitting/paper_features.h"
#include "fitting/paper_knots.h"
#include "fitting/paper_surface.h"

namespace annulus {

/// How the knots of one direction were found.
struct PaperDirection {
  /// Where the most complex section lies: z, mm, of the cross-section; theta, rad, of the longitudinal section.
  double place = 0.0;
  Complexity complexity;      ///< Of that section; bending in mm/rad or mm/mm.
  double noise_sd = 0.0;      ///< Of one value of that section, mm.
  double gate = 0.0;          ///< SignificanceGate, in sd.
  double lambda = 0.0;        ///< Of eq. 2.4, chosen by generalised cross-validation; rad³ or mm³.
  double effective = 0.0;     ///< Parameters that the fit of one section spends.
  double cost_by_rule = 0.0;  ///< Eq. 2.4, mm², with the knots where eq. 2.6 (and evening) put them …
  double cost_moved = 0.0;    ///< … and after Ceres moved them.
  int iterations = 0;
  KnotPlan plan;  ///< Features and knots as used; x in rad or mm.
};

/// What `fit --method paper` did; kept in the model.
struct PaperFitReport {
  PaperDirection around;           ///< Cross-sections, theta.
  PaperDirection along;            ///< Longitudinal sections, z.
  std::size_t levels = 0;          ///< Levels of the scan from the lowest to the highest that were fitted,
  std::size_t levels_outside = 0;  ///< levels below and above them: not seen all around, or folded;
  std::size_t levels_folded = 0;   ///< levels within that are bridged: their section turned back on itself.
};

/// A surface of the paper's kind with its report.
struct PaperModel {
  PaperSurface surface;
  PaperFitReport report;
};

/// One section with the estimates that its knots came from.
struct PaperSection {
  CurveSamples samples;
  std::vector<SlopeEstimate> slopes;
};
/// What the pictures of a fit show.
struct PaperSections {
  PaperSection around;
  PaperSection along;
  double tensor_error = 0.0;  ///< mm, see TensorApproximation.
};

}  // namespace annulus
