#include "fitting/ring_unknowns.h"

#include <algorithm>
#include <cmath>

#include "base/ensure.h"

namespace annulus {
namespace {

/// Adds the path to a carriage that may have knots of its own: linear between the knots of both. The path's knots are
/// heights by the starting scale.
void AddPath(CarriagePath& carriage, const RingUnknowns& unknowns, double start_scale) {
  if (unknowns.knots_z_mm.empty()) return;
  CarriagePath extra;
  for (const double z : unknowns.knots_z_mm) extra.knots_z_mm.push_back(z * carriage.position_scale / start_scale);
  for (const Eigen::Vector2d& knot : unknowns.path) {
    extra.x_mm.push_back(knot.x());
    extra.y_mm.push_back(knot.y());
  }
  CarriagePath bend = carriage;  // without slope and scale: only what bends
  bend.position_scale = 1.0;
  bend.slope_x = bend.slope_y = 0.0;
  std::vector<double> knots = extra.knots_z_mm;
  knots.insert(knots.end(), bend.knots_z_mm.begin(), bend.knots_z_mm.end());
  std::sort(knots.begin(), knots.end());
  knots.erase(std::unique(knots.begin(), knots.end()), knots.end());
  carriage.knots_z_mm = knots;
  carriage.x_mm.clear();
  carriage.y_mm.clear();
  for (const double z : knots) {
    carriage.x_mm.push_back(bend.At(z).x() + extra.At(z).x());
    carriage.y_mm.push_back(bend.At(z).y() + extra.At(z).y());
  }
}

}  // namespace

RangeTerms TermsOf(const SensorUnknowns& sensor, const RingWideUnknowns& ring) {
  // offset + scale · u + quadratic · u² with u = (reading - working distance) / 100 mm
  constexpr double kStep = 100.0;
  constexpr double kMiddle = kWorkingDistance / kStep;
  const double offset = sensor[sensor_unknown::kOffset] + ring[ring_unknown::kOffset];
  const double scale = sensor[sensor_unknown::kScale] + ring[ring_unknown::kScale];
  const double quadratic = ring[ring_unknown::kQuadratic];
  return {offset - kMiddle * scale + kMiddle * kMiddle * quadratic, (scale - 2.0 * kMiddle * quadratic) / kStep,
          quadratic / (kStep * kStep)};
}

RingCalibration Corrected(const RingCalibration& start, const RingUnknowns& unknowns) {
  ENSURE(unknowns.sensors.size() == start.sensors.size(), "one set of unknowns per sensor");
  RingCalibration result = start;
  for (std::size_t i = 0; i < start.sensors.size(); ++i) {
    const SensorUnknowns& by = unknowns.sensors[i];
    SensorCalibration& sensor = result.sensors[i];
    const RangeTerms terms = TermsOf(by, unknowns.ring);
    sensor.range_offset_mm += terms.offset;
    sensor.range_scale += terms.scale;
    sensor.range_quadratic += terms.quadratic;
    // The shift along e_theta is exact: it changes the radius in second order, too.
    const double radial = sensor.radius_mm + by[sensor_unknown::kRadial];
    const double turned = std::atan2(by[sensor_unknown::kTangential], radial);
    sensor.radius_mm = std::hypot(radial, by[sensor_unknown::kTangential]);
    sensor.theta += turned;
    sensor.aim_lateral += by[sensor_unknown::kLateral] / kWorkingDistance - turned;
    sensor.aim_vertical += by[sensor_unknown::kVertical] / kWorkingDistance;
    sensor.height_mm += by[sensor_unknown::kHeight];
  }
  result.pose.tilt_x += unknowns.ring[ring_unknown::kTiltX];
  result.pose.tilt_y += unknowns.ring[ring_unknown::kTiltY];
  result.carriage.position_scale += unknowns.ring[ring_unknown::kHeightScale];
  result.range_mm_per_c += unknowns.ring[ring_unknown::kTemperature];
  AddPath(result.carriage, unknowns, start.carriage.position_scale);
  return result;
}

void FixGauge(const RingCalibration& start, RingUnknowns& unknowns) {
  using namespace sensor_unknown;
  const auto count = static_cast<double>(unknowns.sensors.size());
  if (unknowns.sensors.empty()) return;
  // The shift (x, y), the turn and the height that the sensors' places have in the mean; beams move along.
  Eigen::Vector2d shift = Eigen::Vector2d::Zero();
  double turn = 0.0;
  double height = 0.0;
  for (std::size_t i = 0; i < unknowns.sensors.size(); ++i) {
    const Eigen::Vector2d e_r(std::cos(start.sensors[i].theta), std::sin(start.sensors[i].theta));
    const SensorUnknowns& by = unknowns.sensors[i];
    shift += (by[kRadial] * e_r + by[kTangential] * Eigen::Vector2d(-e_r.y(), e_r.x())) / count;
    turn += by[kTangential] / start.sensors[i].radius_mm / count;
    height += by[kHeight] / count;
  }
  for (std::size_t i = 0; i < unknowns.sensors.size(); ++i) {
    const Eigen::Vector2d e_r(std::cos(start.sensors[i].theta), std::sin(start.sensors[i].theta));
    SensorUnknowns& by = unknowns.sensors[i];
    by[kRadial] -= shift.dot(e_r);
    by[kTangential] -= shift.dot(Eigen::Vector2d(-e_r.y(), e_r.x())) + turn * start.sensors[i].radius_mm;
    by[kLateral] -= turn * kWorkingDistance;
    by[kHeight] -= height;
  }
}

}  // namespace annulus
