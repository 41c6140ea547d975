#include "fitting/ring_findings.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <set>

#include "base/units.h"

namespace annulus {
namespace {

using Kind = CalibrationTarget::Kind;
using Grade = CalibrationFinding::Grade;

template <class... Numbers>
std::string Text(const char* format, Numbers... numbers) {
  char text[400];
  std::snprintf(text, sizeof text, format, numbers...);
  return text;
}

bool IsColumn(const CalibrationTarget& target) { return target.kind == Kind::kCylinder || target.kind == Kind::kStep; }

struct BinnedMean {
  double sum = 0.0, weight = 0.0;
  [[nodiscard]] double Mean() const { return sum / weight; }
  [[nodiscard]] double Sigma() const { return 1.0 / std::sqrt(weight); }
};

/// The largest run of significance among bins of residuals: two neighbours on the same side, or one alone by far.
struct Trend {
  double worst_mm = 0.0;  ///< Mean residual of the worst bin.
  double worst_sd = 0.0;  ///< In its sds.
  double from = 0.0, to = 0.0;
};

Trend TrendOf(const std::vector<BinResidual>& residuals, double low, double step, std::size_t count,
              const std::function<double(const BinResidual&)>& coordinate) {
  std::vector<BinnedMean> bins(count);
  for (const BinResidual& residual : residuals) {
    const double place = (coordinate(residual) - low) / step;
    if (!(place >= 0.0 && place < static_cast<double>(count))) continue;
    // Wild ones count as what a normal one could be at most.
    const double value = std::clamp(residual.after_mm, -4.0 * residual.sigma_mm, 4.0 * residual.sigma_mm);
    const double weight = 1.0 / (residual.sigma_mm * residual.sigma_mm);
    bins[static_cast<std::size_t>(place)].sum += weight * value;
    bins[static_cast<std::size_t>(place)].weight += weight;
  }
  Trend trend;
  for (std::size_t k = 0; k < count; ++k) {
    if (bins[k].weight <= 0.0) continue;
    const double sd = std::abs(bins[k].Mean()) / bins[k].Sigma();
    if (sd <= trend.worst_sd) continue;
    trend = {bins[k].Mean(), sd, low + static_cast<double>(k) * step, low + static_cast<double>(k + 1) * step};
  }
  return trend;
}

void FindPlacementFaults(const CalibrationSetup& setup, RingSolution& solution) {
  const auto say = [&](Grade grade, const char* code, std::string text, std::string advice) {
    solution.findings.push_back({grade, code, std::move(text), std::move(advice)});
  };
  std::size_t off_centre = 0;
  std::size_t tilted = 0;
  std::size_t columns = 0;
  for (const PlacementResult& placement : solution.placements) {
    if (placement.motion.seen && placement.motion.largest_mm > std::max(0.15, 6.0 * placement.motion.sigma_mm)) {
      say(Grade::kFailure, "target_moved",
          placement.name + Text(": two sweeps saw the target %.2f mm apart", placement.motion.largest_mm),
          "the target moved or was touched while it was scanned: the errors of all sensors take part of that; scan "
          "this "
          "placement again and leave the target alone");
    }
    if (!IsColumn(setup.targets[placement.target])) continue;
    ++columns;
    if (placement.off_centre_mm > 50.0) ++off_centre;
    if (placement.tilt_rad > RadiansFromDegrees(3.0)) ++tilted;
  }
  if (solution.placements.size() == 1) {
    say(Grade::kFailure, "one_placement", "the target was scanned in one place only",
        "its shape and the sensors' errors cannot be told apart, nor where beams point: offsets take the target's "
        "errors, "
        "aims stay as drawn; scan it in at least six places, turned and tilted");
  } else if (columns > 0 && (off_centre < 3 || tilted < 3)) {
    say(Grade::kWarning, "few_placements",
        Text("%zu placements stood more than 50 mm off the centre and %zu were tilted by more than 3 degrees",
             off_centre, tilted),
        "sideways and vertical aims rest on few readings; add placements off the centre and tilted in other "
        "directions");
  }
}

void FindRingFaults(const CalibrationSetup& setup, RingSolution& solution) {
  const RingPose& pose = solution.calibration.pose;
  const double tilt = std::hypot(pose.tilt_x, pose.tilt_y);
  if (tilt > RadiansFromDegrees(0.5)) {
    const double apart = 2.0 * tilt * 900.0 / kTwoPi;
    solution.findings.push_back(
        {Grade::kWarning, "ring_not_level",
         Text("the ring's plane is tilted by %.2f degrees against its way", DegreesFromRadians(tilt)),
         Text(
             "front and back of a waist are read %.0f mm apart in height; points are corrected, but the first and last "
             "levels of a scan are seen on one side only: level the ring and calibrate again",
             apart)});
  }
  std::size_t certified = 0;
  std::vector<std::string> misses;
  for (std::size_t t = 0; t < solution.targets.size(); ++t) {
    if (setup.targets[t].kind == Kind::kPlane) continue;
    ++certified;
    const TargetResult& target = solution.targets[t];
    if (!(target.radius_miss_sigma_mm > 0.0)) continue;
    // One calibration in 80 with certificates that are only as good as their U is named in vain; 3 sds would let
    // 0.1 mm pass.
    if (std::abs(target.radius_miss_mm) < std::max(0.03, 2.5 * target.radius_miss_sigma_mm)) continue;
    misses.push_back(Text("%.4g mm: the others make it %+.3f mm (sd %.3f)", target.certified_radius_mm,
                          target.radius_miss_mm, target.radius_miss_sigma_mm));
  }
  if (!misses.empty()) {
    std::string text = "the targets' radii do not agree: ";
    for (std::size_t k = 0; k < misses.size(); ++k) text += (k > 0 ? "; " : "") + misses[k];
    solution.findings.push_back(
        {Grade::kFailure, "radius_disagrees", std::move(text),
         "one of the radii is not what was entered, which one only a third target can say: check the certificates, "
         "temperatures and numbers typed; or the sensors read otherwise on slanting surfaces: use duller targets"});
  } else if (certified == 1) {
    solution.findings.push_back(
        {Grade::kNote, "one_radius", "only one target's radius was used",
         "a wrong radius would go into all girths unseen (0.1 mm is 0.6 mm of girth); verify with a second target"});
  }
}

/// Sensors that no calibration brings into line: wired to another place, loose, or broken.
void FindSensorFaults(const CalibrationSetup& setup, RingSolution& solution) {
  constexpr double kWrong = 4.0;  // mean square in variances of noise; 160 bins scatter by 0.1
  constexpr std::size_t kNamed = 12;
  std::vector<double> squares(setup.start.sensors.size(), 0.0);
  std::vector<double> count(squares.size(), 0.0);
  for (const BinResidual& residual : solution.residuals) {
    squares[residual.sensor] += std::pow(residual.after_mm / residual.sigma_mm, 2);
    count[residual.sensor] += 1.0;
  }
  std::string names;
  std::size_t found = 0;
  for (std::size_t i = 0; i < squares.size(); ++i) {
    if (count[i] < 10.0 || squares[i] < kWrong * count[i]) continue;
    if (found++ < kNamed) names += Text("%s %zu (%.1f sds)", found > 1 ? "," : "", i, std::sqrt(squares[i] / count[i]));
  }
  if (found == 0) return;
  if (found > kNamed) names += Text(" and %zu more", found - kNamed);
  solution.findings.push_back(
      {Grade::kFailure, "sensor_doubtful", "no calibration explains what these sensors read:" + names,
       "they are swapped with others, loose or broken: check channels and mounting, and calibrate "
       "again; the other sensors are not affected"});
}

void FindModelFaults(const CalibrationSetup& setup, RingSolution& solution) {
  constexpr double kSignificant = 5.0;  // sds of the worst of some 20 bins
  constexpr double kMatters = 0.012;    // mm
  const auto judge = [&](const Trend& trend, const char* code, const char* by, const char* unit, const char* advice) {
    if (trend.worst_sd < kSignificant || std::abs(trend.worst_mm) < kMatters) return;
    solution.findings.push_back({Grade::kWarning, code,
                                 Text("residuals depend on the %s: %+.3f mm (%.0f sds) from %.3g to %.3g %s", by,
                                      trend.worst_mm, trend.worst_sd, trend.from, trend.to, unit),
                                 advice});
  };
  judge(TrendOf(solution.residuals, 230.0, 25.0, 20, [](const BinResidual& r) { return r.distance_mm; }),
        "residual_by_distance", "distance", "mm",
        "the range is not linear in the way that was assumed; use placements at more distances and allow the quadratic "
        "term");
  judge(TrendOf(solution.residuals, 0.0, 5.0, 14,
                [](const BinResidual& r) { return DegreesFromRadians(std::acos(std::min(1.0, r.cos_incidence))); }),
        "residual_by_incidence", "angle of incidence", "degrees",
        "the sensors read otherwise on slanting surfaces; use a duller target, and do not trust girths of slanting "
        "sides");
  for (std::size_t t = 0; t < setup.targets.size(); ++t) {
    if (!IsColumn(setup.targets[t])) continue;
    std::vector<BinResidual> own;
    for (const BinResidual& residual : solution.residuals) {
      if (setup.scans[residual.placement].target == t) own.push_back(residual);
    }
    judge(TrendOf(own, 0.0, 10.0, 36, [](const BinResidual& r) { return DegreesFromRadians(WrapAngle(r.phi)); }),
          "residual_by_target_angle", "target's angle", "degrees",
          "the target is less round than eight harmonics can say, dented or dirty, or its turns were entered wrongly");
  }
}

}  // namespace

void FindFaults(const CalibrationSetup& setup, RingSolution& solution) {
  FindPlacementFaults(setup, solution);
  FindRingFaults(setup, solution);
  FindSensorFaults(setup, solution);
  FindModelFaults(setup, solution);
  std::stable_sort(solution.findings.begin(), solution.findings.end(),
                   [](const CalibrationFinding& a, const CalibrationFinding& b) { return a.grade > b.grade; });
}

}  // namespace annulus
