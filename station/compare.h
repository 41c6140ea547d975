#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "base/result.h"
#include "fitting/surface_model.h"
#include "modeling/table/table.h"

namespace annulus {

/// One side of a comparison: a model, and its table made by this program.
struct ComparedScan {
  const SurfaceModel& model;
  const MeasurementTable& table;
};

/// What the ring's own errors do to a difference.
enum class RingErrors {
  kCommon,       ///< Both scans name the same calibration: its errors are the same in both and cancel.
  kIndependent,  ///< Different, or not known: they count twice.
};

/// kCommon if both models say the same calibration by its hash.
[[nodiscard]] RingErrors RingErrorsOf(const Provenance& a, const Provenance& b);

/// The level of all tests of a comparison together.
inline constexpr double kComparisonLevel = 0.05;

/// B minus A of one measurement.
struct Difference {
  std::string id;
  std::string term;
  std::string unit;
  double a = 0.0;
  double b = 0.0;
  double difference = 0.0;   ///< b − a.
  double sigma = 0.0;        ///< sd of the difference; NaN where one of the two is not known.
  double z = 0.0;            ///< difference / sigma; NaN without a sigma.
  double p = 1.0;            ///< Two-sided, normal; NaN without a sigma.
  double p_holm = 1.0;       ///< Corrected for the number of differences tested (Holm 1979); NaN without a sigma.
  bool significant = false;  ///< p_holm < 0.05.
};

/// Two scans compared.
struct Comparison {
  RingErrors ring = RingErrors::kIndependent;
  std::vector<Difference> differences;      ///< In the order of A's table.
  std::vector<std::string> not_comparable;  ///< One sentence each: in one scan only, or differently defined.
};

/// Compares what both scans have under the same id, unit, method and definition. Scans are independent: variances add;
/// calibration's share cancels where both scans name the same calibration. Pure function of its input.
[[nodiscard]] Comparison Compare(const ComparedScan& a, const ComparedScan& b);

/// Two-sided p-values corrected by Holm's step-down method, in the order given: the smallest times n, the next times
/// n − 1 …, never falling, at most 1. NaN stays NaN and is not counted.
[[nodiscard]] std::vector<double> HolmCorrected(const std::vector<double>& p_values);

/// `{ring_errors, tested, differences: [{id, term, a_mm, b_mm, difference_mm, sigma_mm, low95_mm, high95_mm, z, p,
/// p_holm, significant}], not_comparable}`; the unit in the keys is each measurement's own.
[[nodiscard]] nlohmann::ordered_json ComparisonToJson(const Comparison& comparison);
/// For a terminal.
[[nodiscard]] std::string ComparisonToText(const Comparison& comparison);

}  // namespace annulus
