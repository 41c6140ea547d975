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

/// Mean of a per-sensor functional's posterior and prior variances over the free sensors, as sds.
Observability PerSensor(const RingCovariance& covariance, const CalibrationSetup& setup,
                        const SensorUnknowns& direction) {
  Observability result;
  result.unit = "mm";
  const std::size_t sensors = setup.start.sensors.size();
  double prior = 0.0;
  double posterior = 0.0;
  constexpr std::size_t kEvery = 15;
  for (std::size_t i = 0; i < sensors; i += kEvery) {
    RingFunctional f = covariance.Zero();
    f.by_sensor.assign(sensors, SensorUnknowns::Zero());
    f.by_sensor[i] = direction;
    prior += covariance.PriorVariance(f);
    posterior += covariance.Variance(f);
  }
  const double count = std::ceil(static_cast<double>(sensors) / static_cast<double>(kEvery));
  result.prior_sd = std::sqrt(prior / count);
  result.posterior_sd = std::sqrt(posterior / count);
  return result;
}

Observability Shared(const RingCovariance& covariance, Eigen::Index at) {
  RingFunctional f = covariance.Zero();
  f.by_shared[at] = 1.0;
  Observability result;
  result.prior_sd = std::sqrt(covariance.PriorVariance(f));
  result.posterior_sd = std::sqrt(covariance.Variance(f));
  return result;
}

}  // namespace

EffectiveRadial EffectiveRadialAt(const RingCovariance& covariance, std::size_t sensors, double distance_mm) {
  const double u = (distance_mm - kWorkingDistance) / 100.0;
  SensorUnknowns own = SensorUnknowns::Zero();
  own[sensor_unknown::kRadial] = 1.0;
  own[sensor_unknown::kOffset] = -1.0;
  own[sensor_unknown::kScale] = -u;
  EffectiveRadial effective;
  effective.by_sensor.assign(sensors, own);
  effective.by_shared.setZero(static_cast<Eigen::Index>(sensors), covariance.shared());
  effective.by_shared.col(ring_unknown::kOffset).setConstant(-1.0);
  effective.by_shared.col(ring_unknown::kScale).setConstant(-u);
  effective.by_shared.col(ring_unknown::kQuadratic).setConstant(-u * u);
  return effective;
}

RingFunctional CommonRadialAt(const RingCovariance& covariance, std::size_t sensors, double distance_mm) {
  const EffectiveRadial effective = EffectiveRadialAt(covariance, sensors, distance_mm);
  RingFunctional f;
  f.by_sensor = effective.by_sensor;
  for (SensorUnknowns& by : f.by_sensor) by /= static_cast<double>(sensors);
  f.by_shared = effective.by_shared.colwise().mean().transpose();
  return f;
}

std::vector<Observability> ObserveRing(const CalibrationSetup& setup, const RingCovariance& covariance) {
  using namespace sensor_unknown;
  constexpr double kTold = 0.7;  // share of the tolerance's sd beyond which the readings have said nothing of use
  std::vector<Observability> list;
  const auto add = [&](Observability entry, const char* name, const char* unit, const char* consequence) {
    entry.name = name;
    if (entry.unit.empty()) entry.unit = unit;
    entry.observable = entry.posterior_sd < kTold * entry.prior_sd;
    if (!entry.observable) entry.consequence = consequence;
    list.push_back(std::move(entry));
  };
  const auto direction = [](int first, int second, double sign) {
    SensorUnknowns d = SensorUnknowns::Zero();
    d[first] = std::sqrt(0.5);
    if (second >= 0) {
      d[second] = sign * std::sqrt(0.5);
    } else {
      d[first] = 1.0;
    }
    return d;
  };
  const std::size_t sensors = setup.start.sensors.size();
  Observability effective;
  {
    RingFunctional f = covariance.Zero();
    f.by_sensor.assign(sensors, SensorUnknowns::Zero());
    f.by_sensor[0][kRadial] = 1.0;
    f.by_sensor[0][kOffset] = -1.0;
    effective.prior_sd = std::sqrt(covariance.PriorVariance(f));
    effective.posterior_sd = std::sqrt(covariance.Variance(f));
  }
  add(effective, "range of a sensor", "mm", "Radii of single sensors rest on the tolerances.");
  add(PerSensor(covariance, setup, direction(kOffset, kRadial, 1.0)), "offset against radial position", "mm",
      "A longer offset and a sensor further out are the same to every reading: only their sum is known, and only it "
      "matters.");
  add(PerSensor(covariance, setup, direction(kScale, -1, 0.0)), "range scale of a sensor", "mm per 100 mm",
      "Targets stood at too few distances: radii far from theirs are uncertain.");
  add(PerSensor(covariance, setup, direction(kTangential, kLateral, -1.0)), "lateral position at 450 mm", "mm",
      "No target stood off the centre: where beams point sideways rests on the tolerances.");
  add(PerSensor(covariance, setup, direction(kTangential, kLateral, 1.0)), "tangential position against lateral aim",
      "mm", "Only where a beam passes at 450 mm is known sideways, not both ends of it.");
  add(PerSensor(covariance, setup, direction(kHeight, kVertical, 1.0)), "vertical position at 450 mm", "mm",
      "No target was tilted enough: where beams point in height rests on the tolerances.");
  add(PerSensor(covariance, setup, direction(kHeight, kVertical, -1.0)), "height against vertical aim", "mm",
      "Only where a beam passes at 450 mm is known in height, not both ends of it.");
  const auto common = [&](double distance) {
    const RingFunctional f = CommonRadialAt(covariance, sensors, distance);
    Observability entry;
    entry.prior_sd = std::sqrt(covariance.PriorVariance(f));
    entry.posterior_sd = std::sqrt(covariance.Variance(f));
    return entry;
  };
  add(common(kWorkingDistance), "common offset", "mm", "Girths rest on the tolerances.");
  add(Shared(covariance, ring_unknown::kScale), "common range scale", "mm per 100 mm",
      "Girths far from the targets' distances are uncertain.");
  add(Shared(covariance, ring_unknown::kQuadratic), "common quadratic term", "mm per (100 mm)^2",
      "Not needed unless targets at more distances say so.");
  add(Shared(covariance, ring_unknown::kTiltX), "ring tilt about x", "rad", "No target was tilted enough.");
  add(Shared(covariance, ring_unknown::kTiltY), "ring tilt about y", "rad", "No target was tilted enough.");
  add(Shared(covariance, ring_unknown::kHeightScale), "z scale", "mm/mm",
      "No target had edges at known heights: heights and volumes keep the drive's own scale. Scan a step gauge to know "
      "it.");
  add(Shared(covariance, ring_unknown::kPitch), "carriage pitch", "rad/mm",
      "A tilt of the carriage that changes along its way cannot be seen by targets of these shapes.");
  add(Shared(covariance, ring_unknown::kRoll), "carriage roll", "rad/mm",
      "A tilt of the carriage that changes along its way cannot be seen by targets of these shapes.");
  add(Shared(covariance, ring_unknown::kTemperature), "temperature coefficient", "mm per degree",
      "All placements were scanned at nearly one temperature: the offsets hold there only.");
  return list;
}

void FillUncertainty(const CalibrationSetup& setup, const CalibrationState& state, const PriorSigmas& priors,
                     const RingCovariance& covariance, RingSolution& solution) {
  const std::size_t sensors = setup.start.sensors.size();
  const auto n = static_cast<Eigen::Index>(sensors);
  solution.common_sigma_mm.resize(kCommonCount);
  for (int k = 0; k < kCommonCount; ++k) {
    solution.common_sigma_mm[k] =
        std::sqrt(covariance.Variance(CommonRadialAt(covariance, sensors, kCommonFrom + k * kCommonStep)));
  }
  // Effective radial errors, without the shift of the ring's centre, which is none of a section's own.
  const EffectiveRadial effective = EffectiveRadialAt(covariance, sensors, kWorkingDistance);
  Eigen::MatrixXd joint = covariance.Joint(effective.by_sensor, effective.by_shared);
  Eigen::MatrixXd shift(n, 2);
  for (Eigen::Index i = 0; i < n; ++i) {
    const double theta = setup.start.sensors[static_cast<std::size_t>(i)].theta;
    shift.row(i) << std::cos(theta), std::sin(theta);
  }
  const Eigen::MatrixXd without =
      Eigen::MatrixXd::Identity(n, n) - shift * (shift.transpose() * shift).inverse() * shift.transpose();
  joint = without * joint * without;
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> modes(joint);
  constexpr Eigen::Index kModes = 8;
  const Eigen::Index kept = std::min(kModes, n);
  CalibrationUncertainty uncertainty;
  uncertainty.together_mm =
      modes.eigenvectors().rightCols(kept) * modes.eigenvalues().tail(kept).cwiseMax(0.0).cwiseSqrt().asDiagonal();
  solution.sensor_sigma_mm = joint.diagonal().cwiseMax(0.0).cwiseSqrt();
  for (Eigen::Index i = 0; i < n; ++i) {
    uncertainty.own_mm.push_back(std::sqrt(std::max(0.0, joint(i, i) - uncertainty.together_mm.row(i).squaredNorm())));
  }
  uncertainty.distance_mm = kWorkingDistance;
  RingFunctional height = covariance.Zero();
  height.by_shared[ring_unknown::kHeightScale] = 1.0;
  uncertainty.height_scale_sigma = std::sqrt(covariance.Variance(height));
  uncertainty.height_offset_sigma_mm =
      0.0;  // heights are over the ring's own zero: its place over the floor is homing's
  solution.calibration.uncertainty = std::move(uncertainty);
  for (std::size_t i = 0; i < sensors; ++i) solution.sensor_covariance.push_back(covariance.OfSensor(i));

  const RingFunctional girth = CommonRadialAt(covariance, sensors, 600.0 - 900.0 / kTwoPi);
  const double girth_variance = covariance.Variance(girth);
  double by_targets = 0.0;
  for (std::size_t t = 0; t < setup.targets.size(); ++t) {
    TargetResult target;
    target.form = FormOf(state.forms[t]);
    for (int k = 0; k < kFormUnknowns; ++k) {
      RingFunctional f = covariance.Zero();
      f.by_shared[covariance.FormAt(t) + k] = 1.0;
      target.form_sigma[k] = std::sqrt(covariance.Variance(f));
    }
    double low = 0.0;
    double high = 0.0;
    for (int degree = 0; degree < 360; ++degree) {
      const double out = target.form.OutOfRound(RadiansFromDegrees(degree));
      low = std::min(low, out);
      high = std::max(high, out);
    }
    target.out_of_round_mm = high - low;
    target.certified_radius_mm = priors.forms[t][0];  // replaced by the caller, who knows the temperature
    target.certified_sigma_mm = priors.forms[t][0];
    if (setup.targets[t].kind != Kind::kPlane) {
      RingFunctional radius = covariance.Zero();
      radius.by_shared[covariance.FormAt(t)] = 1.0;
      const double prior = std::max(priors.forms[t][0], 1e-9);
      by_targets += std::pow(covariance.Covariance(girth, radius) / prior, 2);
    }
    solution.targets.push_back(std::move(target));
  }
  const auto line = [&](const char* name, double variance) {
    const double sigma = std::sqrt(std::max(0.0, variance));
    const double girth_mm = kTwoPi * sigma;
    solution.budget.push_back({name, girth_mm, 100.0 * 2.0 * sigma / (900.0 / kTwoPi)});
  };
  line("target radius (U/2 of the certificates)", by_targets);
  line("readings and sensors", girth_variance - by_targets);
  RingFunctional warm = covariance.Zero();
  warm.by_shared[ring_unknown::kTemperature] = 1.0;
  constexpr double kWarming = 3.0;  // degrees: sd of a ring's temperature against that of its calibration
  line("temperature of the ring, 3 degrees off", kWarming * kWarming * covariance.Variance(warm));
  double tilt = 0.0;
  for (const int axis : {ring_unknown::kTiltX, ring_unknown::kTiltY}) {
    RingFunctional f = covariance.Zero();
    f.by_shared[axis] = 1.0;
    tilt += covariance.Variance(f);
  }
  line("tilt of the ring's plane", std::pow(900.0 / kTwoPi * tilt / 4.0, 2));
  double total = 0.0;
  for (const BudgetLine& part : solution.budget) total += part.girth_mm * part.girth_mm;
  solution.budget.push_back({"all together", std::sqrt(total), 0.0});
  double volume = 0.0;
  for (const BudgetLine& part : solution.budget) volume += part.volume_percent * part.volume_percent;
  volume += std::pow(100.0 * solution.calibration.uncertainty->height_scale_sigma, 2);
  solution.budget.back().volume_percent = std::sqrt(volume);
  solution.budget.insert(solution.budget.end() - 1,
                         {"z scale", 0.0, 100.0 * solution.calibration.uncertainty->height_scale_sigma});
}

namespace {

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
    if (std::abs(target.radius_miss_mm) < std::max(0.03, 3.0 * target.radius_miss_sigma_mm)) continue;
    misses.push_back(Text("%.4g mm: the others make it %+.3f mm (sd %.3f)", target.certified_radius_mm,
                          target.radius_miss_mm, target.radius_miss_sigma_mm));
  }
  if (!misses.empty()) {
    std::string text = "the targets' radii do not agree: ";
    for (std::size_t k = 0; k < misses.size(); ++k) text += (k > 0 ? "; " : "") + misses[k];
    solution.findings.push_back(
        {Grade::kFailure, "radius_disagrees", std::move(text),
         "one of the radii is not what was entered; which one, only a third target can say: check "
         "the certificates, temperatures and numbers typed"});
  } else if (certified == 1) {
    solution.findings.push_back(
        {Grade::kNote, "one_radius", "only one target's radius was used",
         "a wrong radius would go into all girths unseen (0.1 mm is 0.6 mm of girth); verify with a second target"});
  }
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
  FindModelFaults(setup, solution);
  std::stable_sort(solution.findings.begin(), solution.findings.end(),
                   [](const CalibrationFinding& a, const CalibrationFinding& b) { return a.grade > b.grade; });
}

}  // namespace annulus
