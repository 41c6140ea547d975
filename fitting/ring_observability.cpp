#include "fitting/ring_observability.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "base/ensure.h"
#include "base/units.h"
#include "fitting/ring_uncertainty.h"

namespace annulus {
namespace {

/// The sds that matter. Points of a waist lie 150 mm from the axis, 450 mm from their sensors; targets and bodies are
/// seen within 150 mm of that distance.
constexpr double kNear = 150.0;                                            // mm
constexpr double kCommon = 0.1;                                            // mm of radius: 0.6 mm of girth
constexpr double kOwn = 0.15;                                              // mm of one sensor's radius
constexpr double kSideways = kWorkingDistance * RadiansFromDegrees(0.02);  // mm
constexpr double kUpwards = kWorkingDistance * RadiansFromDegrees(0.1);    // mm
constexpr double kWarming = 3.0;                                           // degrees between calibrations and scans
constexpr double kStature = 2e-4;                                          // of a height: 0.4 mm of a stature
constexpr double kGuide = RadiansFromDegrees(0.02) / 1000.0;               // rad/mm: a level on the carriage tells that
constexpr double kStraight = 0.1;                                          // mm

Observability Judged(Observability entry, const char* consequence) {
  entry.observable = entry.posterior_sd <= entry.required_sd;
  if (!entry.observable) entry.consequence = consequence;
  return entry;
}

Observability Observe(const RingCovariance& covariance, const RingFunctional& f, double required) {
  Observability entry;
  entry.prior_sd = std::sqrt(covariance.PriorVariance(f));
  entry.posterior_sd = std::sqrt(std::max(0.0, covariance.Variance(f)));
  entry.required_sd = required;
  return entry;
}

/// What is asked about single sensors: a combination of their unknowns.
struct SensorQuestion {
  const char* name;
  const char* unit;
  SensorUnknowns direction;
  double required;
  const char* consequence;
};

SensorUnknowns Direction(int first, double by_first, int second, double by_second) {
  SensorUnknowns direction = SensorUnknowns::Zero();
  direction[first] = by_first;
  direction[second] += by_second;
  return direction;
}

/// Each part of a sum has to be as good as the sum if it is to be known by itself.
std::vector<SensorQuestion> SensorQuestions() {
  using namespace sensor_unknown;
  return {
      {"range of a sensor", "mm", Direction(kRadial, 1.0, kOffset, -1.0), kOwn,
       "Radii of single sensors rest on the tolerances."},
      {"offset against radial position", "mm", Direction(kOffset, 0.5, kRadial, 0.5), kOwn,
       "A longer offset and a sensor further out are the same to every reading: only what both make together is known, "
       "and only it matters."},
      {"range scale of a sensor", "mm per 100 mm", Direction(kScale, 1.0, kOffset, 0.0), 100.0 * kOwn / kNear,
       "Targets stood at too few distances: radii far from theirs are uncertain."},
      {"lateral position at 450 mm", "mm", Direction(kTangential, 1.0, kLateral, -1.0), kSideways,
       "Too few targets stood off the centre: where beams point sideways rests on the tolerances."},
      {"tangential position against lateral aim", "mm", Direction(kTangential, 0.5, kLateral, 0.5), kSideways,
       "Only where a beam passes at 450 mm is known sideways, not both ends of it."},
      {"vertical position at 450 mm", "mm", Direction(kHeight, 1.0, kVertical, 1.0), kUpwards,
       "Too few targets were tilted: where beams point in height rests on the tolerances."},
      {"height against vertical aim", "mm", Direction(kHeight, 0.5, kVertical, -0.5), kUpwards,
       "Only where a beam passes at 450 mm is known in height, not both ends of it."},
  };
}

/// The question about sensor `i` against the ring as a whole: less the mean and the first harmonic over all sensors,
/// which are the ring's radius, place and tilt.
RingFunctional AgainstRing(const CalibrationSetup& setup, const RingCovariance& covariance, std::size_t i,
                           const SensorUnknowns& direction) {
  const std::size_t sensors = setup.start.sensors.size();
  const auto wave = [&](std::size_t k) {
    const double theta = setup.start.sensors[k].theta;
    return Eigen::Vector3d(1.0, std::cos(theta), std::sin(theta));
  };
  Eigen::Matrix3d normal = 1e-9 * Eigen::Matrix3d::Identity();
  for (std::size_t k = 0; k < sensors; ++k) normal += wave(k) * wave(k).transpose();
  const Eigen::Vector3d share = normal.inverse() * wave(i);
  RingFunctional f = covariance.Zero();
  f.by_sensor.assign(sensors, SensorUnknowns::Zero());
  for (std::size_t k = 0; k < sensors; ++k) f.by_sensor[k] = ((k == i ? 1.0 : 0.0) - wave(k).dot(share)) * direction;
  return f;
}

/// The mean square over every 15th free sensor.
Observability ObserveSensors(const CalibrationSetup& setup, const RingCovariance& covariance,
                             const SensorQuestion& question) {
  constexpr std::size_t kEvery = 15;
  Observability result;
  double count = 0.0;
  std::size_t next = 0;
  for (std::size_t i = 0; i < setup.start.sensors.size(); ++i) {
    if (i < next || covariance.IsHeld(i)) continue;
    next = i + kEvery;
    const Observability one =
        Observe(covariance, AgainstRing(setup, covariance, i, question.direction), question.required);
    result.prior_sd += one.prior_sd * one.prior_sd;
    result.posterior_sd += one.posterior_sd * one.posterior_sd;
    count += 1.0;
  }
  result.name = question.name;
  result.unit = question.unit;
  result.prior_sd = std::sqrt(result.prior_sd / std::max(1.0, count));
  result.posterior_sd = std::sqrt(result.posterior_sd / std::max(1.0, count));
  result.required_sd = question.required;
  return Judged(std::move(result), question.consequence);
}

/// The path's largest sd from the straight line through it: place and direction are the targets' own.
Observability ObserveStraightness(const CalibrationSetup& setup, const RingCovariance& covariance,
                                  const std::vector<double>& knots_z_mm) {
  const auto n = static_cast<Eigen::Index>(knots_z_mm.size());
  Eigen::MatrixXd line(n, 2);
  for (Eigen::Index k = 0; k < n; ++k) line.row(k) << 1.0, knots_z_mm[static_cast<std::size_t>(k)] - setup.middle_z_mm;
  const Eigen::MatrixXd bend =
      Eigen::MatrixXd::Identity(n, n) - line * (line.transpose() * line).inverse() * line.transpose();
  Observability worst;
  for (Eigen::Index k = 0; k < n; ++k) {
    for (Eigen::Index axis = 0; axis < 2; ++axis) {
      RingFunctional f = covariance.Zero();
      for (Eigen::Index j = 0; j < n; ++j)
        f.by_shared[covariance.PathAt(static_cast<std::size_t>(j)) + axis] = bend(k, j);
      Observability one = Observe(covariance, f, kStraight);
      if (one.posterior_sd >= worst.posterior_sd) worst = std::move(one);
    }
  }
  worst.unit = "mm";
  return worst;
}

std::string Heights(const char* format, double low, double high) {
  std::array<char, 120> text{};
  std::snprintf(text.data(), text.size(), format, low, high);
  return text.data();
}

void ObservePath(const CalibrationSetup& setup, const RingCovariance& covariance, std::vector<Observability>& list) {
  const std::vector<double> knots = PathKnots(setup.placements, setup.knot_spacing_mm);
  Observability inside = ObserveStraightness(setup, covariance, knots);
  inside.name = Heights("straightness from %.0f to %.0f mm", knots.front(), knots.back());
  list.push_back(Judged(std::move(inside), "Targets were seen over too little of these heights."));
  Observability outside;
  outside.name = Heights("straightness below %.0f and above %.0f mm", knots.front(), knots.back());
  outside.unit = "mm";
  outside.prior_sd = outside.posterior_sd = covariance.path_prior_mm();
  outside.required_sd = kStraight;
  list.push_back(Judged(std::move(outside),
                        "No target stood at these heights: the carriage is taken to go straight on there. Stand a "
                        "target higher or lower to know it."));
}

struct RingQuestion {
  const char* name;
  const char* unit;
  double required;
  const char* consequence;
};

RingQuestion QuestionOf(int unknown) {
  const double tilt = kUpwards / kNear;
  switch (unknown) {
    case ring_unknown::kScale:
      return {"common range scale", "mm per 100 mm", 100.0 * kCommon / kNear,
              "Girths far from the targets' distances are uncertain: use targets of other radii, and off the centre."};
    case ring_unknown::kQuadratic:
      return {"common quadratic term", "mm per (100 mm)^2", 1e4 * kCommon / (kNear * kNear),
              "Targets at too few distances: the range is taken to be linear."};
    case ring_unknown::kTiltX:
      return {"ring tilt about x", "rad", tilt, "Too few targets were tilted: the ring is taken to be level."};
    case ring_unknown::kTiltY:
      return {"ring tilt about y", "rad", tilt, "Too few targets were tilted: the ring is taken to be level."};
    case ring_unknown::kHeightScale:
      return {"z scale", "mm/mm", kStature,
              "No target had edges at known heights: heights and volumes keep the drive's own scale. Scan a step gauge "
              "to know it."};
    case ring_unknown::kTemperature:
      return {"temperature coefficient", "mm per degree", kCommon / kWarming,
              "All placements were scanned at nearly one temperature: the offsets hold there only."};
    case ring_unknown::kPitch:
      return {"carriage pitch", "rad/mm", kGuide,
              "A tilt of the carriage that changes along its way hardly shows on targets of these shapes: lay a level "
              "on the carriage if in doubt."};
    case ring_unknown::kRoll:
      return {"carriage roll", "rad/mm", kGuide,
              "A tilt of the carriage that changes along its way hardly shows on targets of these shapes: lay a level "
              "on the carriage if in doubt."};
    default:
      break;
  }
  return {"common offset", "mm", kCommon, "Girths rest on the tolerances."};
}

}  // namespace

Observability ObserveRingUnknown(const RingCovariance& covariance, int unknown) {
  ENSURE(unknown >= 0 && unknown < ring_unknown::kCount, "it is an unknown of the ring");
  const RingQuestion question = QuestionOf(unknown);
  RingFunctional f = covariance.Zero();
  f.by_shared[unknown] = 1.0;
  if (unknown == ring_unknown::kScale || unknown == ring_unknown::kOffset) {
    // What all sensors have together is theirs in the mean, too.
    const auto own = unknown == ring_unknown::kScale ? sensor_unknown::kScale : sensor_unknown::kOffset;
    const std::size_t sensors = covariance.sensors();
    f.by_sensor.assign(sensors, SensorUnknowns::Zero());
    for (SensorUnknowns& by : f.by_sensor) by[own] = 1.0 / static_cast<double>(sensors);
  }
  Observability entry = Observe(covariance, f, question.required);
  entry.name = question.name;
  entry.unit = question.unit;
  return Judged(std::move(entry), question.consequence);
}

std::vector<Observability> ObserveRing(const CalibrationSetup& setup, const RingCovariance& covariance,
                                       const RingCovariance& uncertified) {
  std::vector<Observability> list;
  for (const SensorQuestion& question : SensorQuestions()) list.push_back(ObserveSensors(setup, covariance, question));
  const std::size_t sensors = setup.start.sensors.size();
  const auto common = [&](const RingCovariance& by, const char* name, const char* consequence) {
    Observability entry = Observe(by, CommonRadialAt(by, sensors, kWorkingDistance), kCommon);
    entry.name = name;
    entry.unit = "mm";
    list.push_back(Judged(std::move(entry), consequence));
  };
  common(covariance, "common offset", "Girths rest on the tolerances.");
  common(uncertified, "common offset against target radius",
         "A wrong radius and an offset common to all sensors look alike: girths rest on the targets' certificates.");
  using namespace ring_unknown;
  for (const int unknown :
       {ring_unknown::kScale, kQuadratic, kTiltX, kTiltY, kHeightScale, kPitch, kRoll, kTemperature}) {
    list.push_back(ObserveRingUnknown(covariance, unknown));
  }
  ObservePath(setup, covariance, list);
  return list;
}

}  // namespace annulus
