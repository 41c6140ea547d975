#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/progress.h"
#include "base/result.h"
#include "base/surface_sample.h"
#include "fitting/edge_regions.h"
#include "fitting/paper_model.h"
#include "fitting/sample_screening.h"
#include "fitting/section_topology.h"
#include "fitting/surface_model.h"

namespace annulus {

/// How smoothness is weighed.
enum class FitMethod {
  kAdaptive,  ///< Local smoothing weights from the data.
  kUniform,   ///< One smoothing weight each way for the whole surface, chosen by generalised cross-validation.
  kPaper,     ///< Paper 001, §2, to the letter: see FitPaper (fitting/paper_fit.h).
};

/// Whether the model can tell its uncertainty.
enum class CovarianceChoice {
  kKeep,  ///< With the normal matrix.
  kNone,  ///< Without: smaller, and nothing is spent on it.
};

/// What a caller can choose. The defaults need no tuning.
struct FitOptions {
  FitMethod method = FitMethod::kAdaptive;
  std::size_t theta_knots = 0;  ///< kUniform only: knots around; 0 is 48. At most 0.8 per sensor.
  std::size_t z_knots = 0;      ///< kUniform only: intervals in height; 0 is 117 (120 rows of coefficients). Likewise.
  ScreeningOptions screening;
  CovarianceChoice covariance = CovarianceChoice::kKeep;
};

/// A sample that was left out, and why.
struct RejectedSample {
  std::size_t index = 0;  ///< Into the samples given.
  SampleVerdict reason = SampleVerdict::kOutlier;
};

/// Seconds spent per stage.
struct FitTimes {
  double screening_s = 0.0;
  double smoothing_s = 0.0;  ///< Cross-validation.
  double solve_s = 0.0;
  double polish_s = 0.0;
  double knowledge_s = 0.0;
  double total_s = 0.0;  ///< From the samples to the coefficients: all of the above.
  double sigma_s = 0.0;  ///< What the noise, the effective parameters and the uncertainty take on top.
};

/// What the fit did and how well it went.
struct FitSummary {
  static constexpr std::uint8_t kNoSegment = 255;

  std::string termination;  ///< "converged", or why it stopped.
  std::size_t samples = 0;  ///< Given.
  std::size_t used = 0;     ///< Not rejected.
  std::vector<RejectedSample> rejected;
  std::vector<ForegroundObject> foreground;
  std::vector<SectionRegion> regions;  ///< By FitBody: where the scan is not one star-shaped loop.
  /// By FitBody, if there are several segments or regions left out: for each sample its index into the model's
  /// segments, or kNoSegment if it was rejected or left out. Empty: the first segment holds all that is not rejected.
  std::vector<std::uint8_t> segment_of_sample;
  std::size_t coefficients = 0;
  std::vector<EdgeRegion> edges;  ///< Where the smoothing was broken, largest first.
  double noise_sigma_mm = 0.0;    ///< Sd of a return about the surface, steps that it does not follow left out.
  double detail_sigma_mm = 0.0;   ///< kAdaptive: sd of detail that the surface does not follow (fit_uncertainty.h).
  double rms_mm = 0.0;            ///< RMS residual of the used samples.
  /// Smoothing around and upwards. kUniform: weight of a squared second difference, in samples of a cell; kAdaptive:
  /// factors on the local weights; kPaper: λ of eq. 2.4.
  double lambda_theta = 0.0;
  double lambda_z = 0.0;
  double effective_parameters = 0.0;  ///< trace S (Hutchinson estimate, fixed seed).
  double cost_start = 0.0;            ///< Robust cost before and after the polish.
  double cost_end = 0.0;
  int iterations = 0;  ///< Of the polish.
  FitTimes times;
  std::optional<PaperSections> paper;  ///< kPaper only: the sections that its knots came from.

  /// One line for a terminal or a log.
  [[nodiscard]] std::string BriefReport() const;
};

struct FitResult {
  SurfaceModel model;
  FitSummary summary;
};

/// Fits r(theta, z) to the samples of one scan: paper 001, eqs. 2.2–2.4 (squared error plus quadratic variation), by
///   1. screening (neighbourhood, foreground), 2. a coarse pilot with one thin-plate weight chosen by GCV,
///   3. local smoothing weights, 4. a hierarchical spline refined where residuals are not noise,
///   5. a robust polish by Ceres whose scale is local, 6. one step of twicing against the smoothing's bias.
/// Holes are allowed; `model.segments[0].knowledge` says what was seen. Deterministic, one thread.
/// Fails when fewer than 8 levels, 8 sensors or 100 good samples remain, or when they do not determine a surface.
[[nodiscard]] Result<FitResult> FitSurface(std::span<const SurfaceSample> samples, const FitOptions& options,
                                           const TaskContext& context);

}  // namespace annulus
