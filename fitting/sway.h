#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/surface_sample.h"
#include "fitting/sway_motion.h"
#include "fitting/sway_posterior.h"
#include "fitting/systematic_errors.h"

namespace annulus {

/// One reading of a range sensor that stands still and looks at the person while the ring travels.
struct ReferenceReading {
  double time_s = 0.0;                                   ///< s since the first level of the scan, as the samples' time.
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();      ///< Of its ray, mm, station frame.
  Eigen::Vector3d direction = Eigen::Vector3d::UnitX();  ///< Unit vector towards the person, station frame.
  double range = 0.0;        ///< mm along the ray; readings that are not finite are left out.
  std::uint16_t sensor = 0;  ///< Which of the fixed sensors; < 64.
};

/// What a caller can choose. The defaults need no tuning.
struct SwayOptions {
  SwayPrior prior;
  double reference_sigma_mm = 0.5;  ///< sd of the noise of a fixed sensor's reading.
  int rounds = 3;                   ///< Linearisations, each with the body put together anew.
};

/// How the sway was seen.
enum class SwayView {
  kUnknown,  ///< The samples have no times, or are no levels: nothing can be said.
  kNotSeen,  ///< One sweep and no fixed sensors: what is stated is what people do, not what this one did.
  kSeen,     ///< Heights were scanned several times, or fixed sensors looked.
};

/// The motion while one level was taken.
struct SwayLevel {
  std::uint16_t sweep = 0;
  std::uint32_t level = 0;
  double time_s = 0.0;
  double z = 0.0;     ///< mm
  SwayMotion motion;  ///< Estimated displacement from the scan's mean.
  SwayMotion sigma;   ///< sd of its error: with the part common to all sweeps.
};

/// A number of the sway with its uncertainty.
struct SwayNumber {
  double value = 0.0;
  double sigma = 0.0;
  double low95 = 0.0;
  double high95 = 0.0;
};

/// The sway in numbers; x sideways and y front-back at kSwayHeight.
struct SwaySummary {
  SwayNumber sd_x, sd_y;        ///< sd over the scan's time, mm.
  SwayNumber sd_yaw;            ///< rad
  SwayNumber range_x, range_y;  ///< Largest less least over the scan's time, mm.
  double removed_mm = 0.0;      ///< RMS over the levels of the horizontal displacement that was taken out.
  double remaining_mm = 0.0;    ///< Expected RMS over the heights of what the surface's sections are displaced by, mean
                                ///< translation and lean left out: what all sweeps have in common is in it.
  double unremoved_mm = 0.0;    ///< The same if nothing had been taken out.
  double scale = 1.0;           ///< Of the person's sway, 1 is typical.
  std::size_t levels = 0;       ///< That were compared.
  std::size_t sweeps = 0;
  std::size_t references = 0;  ///< Readings of fixed sensors that were used.
};

struct SwayEstimate {
  SwayView view = SwayView::kUnknown;
  std::string reason;                    ///< Why it is not seen, or not worth a correction; else empty.
  std::vector<SwayLevel> levels;         ///< In order of time.
  std::vector<SurfaceSample> corrected;  ///< The samples moved back; as they were where nothing was seen.
  /// Of a surface that is fitted to `corrected`, full form, without a displacement or turn that all sections share;
  /// nothing if unknown, or if the person stood still.
  std::optional<SwayErrors> errors;
  SwaySummary summary;

  /// One line for a terminal or a log.
  [[nodiscard]] std::string BriefReport() const;
};

/// Estimates how the person swayed during a scan, jointly with the body's shape, and moves the samples back.
///
/// A body displaced by a motion (lean, yaw, shift) has the radii r + J·motion (RadiusByMotion). Every level is compared
/// with a surface of all levels by robust least squares, growth by breath being a term of its own; the comparisons and
/// the fixed sensors' readings together give the motion as a Gaussian process over time, whatever the body's shape
/// (SolveSway); the points are moved back and everything is linearised again. Radii of levels that are not aligned are
/// never averaged. Sweeps show only how they differ: they are moved onto their mean, and what they have in common at a
/// height is neither removed nor claimed to be, but stays in `errors`. Fixed sensors show it, and then it is removed.
///
/// `samples` of one scan, of one person, in any order; times in s. Deterministic, one thread, about a second.
[[nodiscard]] SwayEstimate EstimateSway(std::span<const SurfaceSample> samples,
                                        std::span<const ReferenceReading> references, const SwayOptions& options);

}  // namespace annulus
