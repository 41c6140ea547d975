#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <string>
#include <vector>

#include "base/calibration_target.h"
#include "base/progress.h"
#include "base/result.h"
#include "base/ring_calibration.h"
#include "fitting/placement_bins.h"
#include "fitting/ring_problem.h"

namespace annulus {

/// Whether the range gets a term in the square of the reading.
enum class QuadraticTerm {
  kIfNeeded,  ///< If it comes out 2 sds or more from 0.
  kNever,
};

struct CalibrateOptions {
  RingTolerances tolerances;
  QuadraticTerm quadratic = QuadraticTerm::kIfNeeded;
  /// The sensors that are solved for, one flag each; empty: all. With some held, so are ring and carriage: a replaced
  /// board is calibrated alone against the ring around it.
  std::vector<bool> free_sensors;
  std::size_t board_size = 15;     ///< Sensors of a board: boards may be exchanged as a whole.
  double knot_spacing_mm = 150.0;  ///< Of the carriage's path.
  int threads = 1;                 ///< More than one: results differ in the last bits from run to run.
};

/// How well one quantity is known: its sd before and after the readings.
struct Observability {
  std::string name;       ///< "z scale", "offset against radial position" …
  std::string unit;       ///< "mm", "mm/mm" …
  double prior_sd = 0.0;  ///< From the tolerances alone.
  double posterior_sd = 0.0;
  double required_sd = 0.0;  ///< What matters to girths and heights: from the accuracy that is asked of the ring.
  bool observable = false;   ///< posterior_sd <= required_sd.
  std::string consequence;   ///< What it means if it is not; a sentence.
};

/// A placement after the solve.
struct PlacementResult {
  std::string name;
  std::size_t target = 0;
  TargetPose pose;             ///< Station frame; of a column at the height pose.z.
  double tilt_rad = 0.0;       ///< Of a column's axis or a board against the vertical.
  double off_centre_mm = 0.0;  ///< Of a column's or sphere's place from the ring's centre.
  double noise_mm = 0.0;       ///< sd of one full return.
  double rms_before_mm = 0.0;  ///< Of the bins' residuals with the starting calibration, at its best pose.
  double rms_after_mm = 0.0;
  double z_low_mm = 0.0, z_high_mm = 0.0;
  std::size_t readings = 0, rejected = 0, elsewhere = 0;
  TargetMotion motion;
};

/// A target after the solve.
struct TargetResult {
  TargetForm form;
  FormUnknowns form_sigma;           ///< As FormUnknowns.
  double certified_radius_mm = 0.0;  ///< At the placements' mean temperature.
  double certified_sigma_mm = 0.0;   ///< U/2.
  /// What all other readings say of the radius without this target's certificate, less the certified one; NaN if they
  /// say nothing. Meaningless for planes.
  double radius_miss_mm = 0.0;
  double radius_miss_sigma_mm = 0.0;
  double out_of_round_mm = 0.0;  ///< Largest less smallest radius.
};

/// Something that a technician has to know.
struct CalibrationFinding {
  enum class Grade { kNote, kWarning, kFailure };
  Grade grade = Grade::kNote;
  std::string code;    ///< "target_moved", "one_placement", …; docs/technician.md
  std::string text;    ///< What was seen.
  std::string advice;  ///< What to do, or what follows; without a full stop.
};

/// One line of the error budget of a girth of 900 mm around the ring's centre.
struct BudgetLine {
  std::string name;
  double girth_mm = 0.0;        ///< sd of the girth, mm.
  double volume_percent = 0.0;  ///< sd of a volume under that girth, %.
};

/// A bin with its residual, for pictures and tests.
struct BinResidual {
  std::size_t placement = 0;
  std::uint16_t sensor = 0;
  double z_mm = 0.0;
  double before_mm = 0.0;  ///< Measured less expected distance with the starting calibration.
  double after_mm = 0.0;
  double sigma_mm = 0.0;  ///< That noise alone gives it.
  double distance_mm = 0.0, cos_incidence = 1.0, phi = 0.0;
};

/// Sensors that stand in each other's place: their plugs or their places in the map are exchanged.
struct SensorExchange {
  std::size_t a = 0;      ///< Index of the first sensor.
  std::size_t b = 0;      ///< Of the one that it is exchanged with, > a.
  std::size_t count = 1;  ///< So many following sensors of both are exchanged, too: 1, or a board's.
  double evidence = 0.0;  ///< By so much exchanging them lowers the sum of squared residuals, in variances.
};

struct RingSolution {
  RingCalibration calibration;  ///< With uncertainty and without serial and certificate, which are the caller's.
  RingUnknowns corrections;     ///< Of the starting calibration, gauge fixed.
  std::vector<Eigen::Matrix<double, 7, 7>> sensor_covariance;  ///< Of `corrections`, free sensors; else zero.
  Eigen::VectorXd common_sigma_mm;  ///< sd of the mean effective radial error at 250, 300 … 550 mm.
  Eigen::VectorXd sensor_sigma_mm;  ///< By sensor: sd of its own effective radial error at 450 mm.
  std::vector<PlacementResult> placements;
  std::vector<TargetResult> targets;
  std::vector<Observability> observability;
  std::vector<CalibrationFinding> findings;
  std::vector<BudgetLine> budget;  ///< Last line: all together.
  std::vector<BinResidual> residuals;
  std::vector<SensorExchange> exchanges;  ///< Not corrected: the calibration is of no use until they are.
  bool quadratic = false;                 ///< A quadratic term was needed.
  bool height_scale = false;              ///< Heights were measured by a step target.
  double noise_mm = 0.0;
  double chi_square = 0.0;  ///< Of the bins, per degree of freedom.
  double cost_start = 0.0, cost_end = 0.0;
  int iterations = 0;
  double time_s = 0.0;
  std::string termination;

  [[nodiscard]] bool failed() const;  ///< A finding of grade failure.
  [[nodiscard]] std::string BriefReport() const;
};

/// Heights and distances of RingSolution::common_sigma_mm.
inline constexpr double kCommonFrom = 250.0;
inline constexpr double kCommonStep = 50.0;
inline constexpr int kCommonCount = 7;

/// Solves for everything that is unknown of a ring from scans of targets in several places (Ceres; the seven unknowns
/// of each sensor are eliminated). Readings are of the sensors of `start`, which is what the ring is believed to be: an
/// ideal one, or its last calibration. The target's shape and the sensors' errors come apart because the target is
/// turned and moved between scans (multi-probe separation: Whitehouse 1976); gauge freedoms are fixed by FixGauge.
/// With one thread the same input gives the same bits. Fails if a target is not found, or if readings determine
/// nothing.
[[nodiscard]] Result<RingSolution> CalibrateRing(const RingCalibration& start,
                                                 const std::vector<CalibrationTarget>& targets,
                                                 const std::vector<TargetScan>& scans, const CalibrateOptions& options,
                                                 const TaskContext& context);

}  // namespace annulus
