#include "fitting/ring_problem.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>

namespace annulus {
namespace {

using Kind = CalibrationTarget::Kind;

constexpr double kTaperLength = 500.0;  // mm

/// A sensor's beam in the station frame with its corrections, and what the derivatives need of it.
struct Beam {
  Ray ray;
  Eigen::Matrix3d carriage_from_ring;
  Eigen::Vector3d in_ring;                  ///< Origin in the carriage's frame after the pose's turn.
  Eigen::Vector3d e_r, e_t, e_z;            ///< The sensor's own directions, station frame.
  Eigen::Vector3d by_lateral, by_vertical;  ///< Derivatives of the direction, per rad.
  Eigen::Vector3d axis_x, axis_y;           ///< Axes of the pose's two tilts, station frame.
};

/// Where a carriage is at a reported height if its scale is larger by `scale`.
Eigen::Vector3d CarriageAt(const CarriagePath& carriage, double reported_z, double scale) {
  return carriage.At((carriage.position_scale + scale) * reported_z / carriage.position_scale);
}

Beam BeamOf(const CalibrationSetup& setup, const TargetBin& bin, const BinUnknowns& u, const Eigen::Vector2d& path) {
  const SensorCalibration& s = setup.start.sensors[bin.sensor];
  const double heading = s.theta + kPi + s.aim_lateral + u.sensor[sensor_unknown::kLateral] / kWorkingDistance;
  const double raised = s.aim_vertical + u.sensor[sensor_unknown::kVertical] / kWorkingDistance;
  const Eigen::Vector3d direction(std::cos(raised) * std::cos(heading), std::cos(raised) * std::sin(heading),
                                  std::sin(raised));
  const Eigen::Vector3d e_r = PointFromCylindrical(s.theta, 1.0, 0.0);
  const Eigen::Vector3d e_t(-e_r.y(), e_r.x(), 0.0);
  const Eigen::Vector3d origin = (s.radius_mm + u.sensor[sensor_unknown::kRadial]) * e_r +
                                 u.sensor[sensor_unknown::kTangential] * e_t +
                                 (s.height_mm + u.sensor[sensor_unknown::kHeight]) * Eigen::Vector3d::UnitZ();
  const Eigen::Matrix3d about_y =
      Eigen::AngleAxisd(setup.start.pose.tilt_y + u.ring[ring_unknown::kTiltY], Eigen::Vector3d::UnitY())
          .toRotationMatrix();
  const Eigen::Matrix3d about_x =
      Eigen::AngleAxisd(setup.start.pose.tilt_x + u.ring[ring_unknown::kTiltX], Eigen::Vector3d::UnitX())
          .toRotationMatrix();
  Beam beam;
  beam.carriage_from_ring = about_y * about_x;
  beam.in_ring = beam.carriage_from_ring * origin;
  const Eigen::Vector3d at = CarriageAt(setup.start.carriage, bin.z_mm, u.ring[ring_unknown::kHeightScale]) +
                             Eigen::Vector3d(path.x() + setup.start.pose.x_mm, path.y() + setup.start.pose.y_mm, 0.0);
  beam.ray = {at + beam.in_ring, beam.carriage_from_ring * direction};
  beam.e_r = beam.carriage_from_ring * e_r;
  beam.e_t = beam.carriage_from_ring * e_t;
  beam.e_z = beam.carriage_from_ring * Eigen::Vector3d::UnitZ();
  beam.by_lateral = beam.carriage_from_ring * Eigen::Vector3d(-direction.y(), direction.x(), 0.0);
  beam.by_vertical = beam.carriage_from_ring * Eigen::Vector3d(-std::sin(raised) * std::cos(heading),
                                                               -std::sin(raised) * std::sin(heading), std::cos(raised));
  beam.axis_x = about_y * Eigen::Vector3d::UnitX();
  beam.axis_y = Eigen::Vector3d::UnitY();
  return beam;
}

/// How the carriage goes on per mm of height, station frame.
Eigen::Vector3d WayPerHeight(const CarriagePath& carriage, double reported_z) {
  if (carriage.knots_z_mm.empty()) return {carriage.slope_x, carriage.slope_y, 1.0};
  constexpr double kHalf = 0.25;  // mm
  return (carriage.At(reported_z + kHalf) - carriage.At(reported_z - kHalf)) / (2.0 * kHalf * carriage.position_scale);
}

/// Derivatives of g·(origin + distance·direction) by sensor, ring and path, where g is a fixed vector.
void FollowBeam(const CalibrationSetup& setup, const TargetBin& bin, const Beam& beam, double distance,
                const Eigen::Vector3d& g, BinRow& row) {
  using namespace sensor_unknown;
  const auto turned = [&](const Eigen::Vector3d& axis) {
    return g.dot(axis.cross(beam.in_ring + distance * beam.ray.direction));
  };
  row.by_sensor[kRadial] = g.dot(beam.e_r);
  row.by_sensor[kTangential] = g.dot(beam.e_t);
  row.by_sensor[kHeight] = g.dot(beam.e_z);
  row.by_sensor[kLateral] = distance / kWorkingDistance * g.dot(beam.by_lateral);
  row.by_sensor[kVertical] = distance / kWorkingDistance * g.dot(beam.by_vertical);
  row.by_ring[ring_unknown::kTiltX] = turned(beam.axis_x);
  row.by_ring[ring_unknown::kTiltY] = turned(beam.axis_y);
  row.by_ring[ring_unknown::kHeightScale] = bin.z_mm * g.dot(WayPerHeight(setup.start.carriage, bin.z_mm));
  row.by_ring[ring_unknown::kPitch] = (bin.z_mm - setup.middle_z_mm) * turned(beam.axis_x);
  row.by_ring[ring_unknown::kRoll] = (bin.z_mm - setup.middle_z_mm) * turned(beam.axis_y);
}

/// Adds what the range's own terms do to a distance at a reading (mm), times `by`.
void FollowRange(const CalibrationSetup& setup, std::size_t placement, double reading, double by, BinRow& row) {
  const double u = (reading - kWorkingDistance) / 100.0;
  row.by_sensor[sensor_unknown::kOffset] += by;
  row.by_sensor[sensor_unknown::kScale] += by * u;
  row.by_ring[ring_unknown::kOffset] += by;
  row.by_ring[ring_unknown::kScale] += by * u;
  row.by_ring[ring_unknown::kQuadratic] += by * u * u;
  const auto& ring_c = setup.scans[placement].ring_c;
  if (ring_c) row.by_ring[ring_unknown::kTemperature] += by * (*ring_c - setup.start.reference_c);
}

/// The range's own curve with its corrections.
SensorCalibration RangeOf(const CalibrationSetup& setup, std::size_t placement, const TargetBin& bin,
                          const BinUnknowns& u) {
  const RangeTerms terms =
      TermsOf(Eigen::Map<const SensorUnknowns>(u.sensor), Eigen::Map<const RingWideUnknowns>(u.ring));
  SensorCalibration range = setup.start.sensors[bin.sensor];
  range.range_offset_mm += terms.offset;
  range.range_scale += terms.scale;
  range.range_quadratic += terms.quadratic;
  if (const auto& ring_c = setup.scans[placement].ring_c) {
    range.range_offset_mm +=
        (setup.start.range_mm_per_c + u.ring[ring_unknown::kTemperature]) * (*ring_c - setup.start.reference_c);
  }
  return range;
}

/// The pose's derivative per mm of the form's units.
void ScaleTaper(BinRow& row) { row.by_form[1] /= kTaperLength; }

void Divide(BinRow& row, double sigma) {
  row.residual /= sigma;
  row.by_sensor /= sigma;
  row.by_ring /= sigma;
  row.by_pose /= sigma;
  row.by_form /= sigma;
  row.by_knot /= sigma;
  row.by_next_knot /= sigma;
}

}  // namespace

TargetForm FormOf(const FormUnknowns& unknowns) {
  TargetForm form;
  form.radius_mm = unknowns[0];
  form.taper = unknowns[1] / kTaperLength;
  for (std::size_t k = 0; k < TargetForm::kOrders; ++k) {
    form.cosine_mm[k] = unknowns[2 + 2 * static_cast<Eigen::Index>(k)];
    form.sine_mm[k] = unknowns[3 + 2 * static_cast<Eigen::Index>(k)];
  }
  return form;
}

TargetPose PoseOf(const PoseUnknowns& unknowns) {
  TargetPose pose;
  pose.x = unknowns[0];
  pose.y = unknowns[1];
  pose.slope_x = unknowns[2];
  pose.slope_y = unknowns[3];
  pose.turn = unknowns[4];
  pose.z = unknowns[5];
  return pose;
}

PoseUnknowns UnknownsOf(const TargetPose& pose) {
  PoseUnknowns unknowns;
  unknowns << pose.x, pose.y, pose.slope_x, pose.slope_y, pose.turn, pose.z;
  return unknowns;
}

std::pair<std::size_t, double> KnotAt(const std::vector<double>& knots_z_mm, double z) {
  if (knots_z_mm.size() < 2) return {0, 0.0};
  const auto above = std::upper_bound(knots_z_mm.begin() + 1, knots_z_mm.end() - 1, z);
  const auto k = static_cast<std::size_t>(above - knots_z_mm.begin()) - 1;
  return {k, std::clamp((z - knots_z_mm[k]) / (knots_z_mm[k + 1] - knots_z_mm[k]), 0.0, 1.0)};
}

std::vector<double> PathKnots(const std::vector<PlacementBins>& placements, double spacing_mm) {
  double low = 1e9;
  double high = -1e9;
  for (const PlacementBins& placement : placements) {
    low = std::min(low, placement.z_low);
    high = std::max(high, placement.z_high);
  }
  if (!(high > low)) return {0.0, 1.0};
  const auto spans = std::max<std::size_t>(1, static_cast<std::size_t>(std::ceil((high - low) / spacing_mm)));
  std::vector<double> knots;
  for (std::size_t k = 0; k <= spans; ++k) {
    knots.push_back(low + (high - low) * static_cast<double>(k) / static_cast<double>(spans));
  }
  return knots;
}

bool EvaluateBin(const CalibrationSetup& setup, std::size_t placement, const TargetBin& bin,
                 const std::vector<double>& knots_z_mm, const BinUnknowns& u, BinRow& row) {
  const CalibrationTarget& target = setup.targets[setup.scans[placement].target];
  const TargetForm form = FormOf(Eigen::Map<const FormUnknowns>(u.form));
  const TargetPose pose = PoseOf(Eigen::Map<const PoseUnknowns>(u.pose));
  const auto [knot, above] = KnotAt(knots_z_mm, setup.start.carriage.position_scale * bin.z_mm);
  const Eigen::Vector2d path((1.0 - above) * u.knot[0] + above * u.next_knot[0],
                             (1.0 - above) * u.knot[1] + above * u.next_knot[1]);
  const Beam beam = BeamOf(setup, bin, u, path);
  const SensorCalibration range = RangeOf(setup, placement, bin, u);
  row = BinRow{};
  row.knot = knot;
  if (bin.edge >= 0) {
    // How high over the target's foot the beam passed the edge, less what the target says.
    const Eigen::Vector3d along = Eigen::Vector3d(pose.slope_x, pose.slope_y, 1.0).normalized();
    const double steep = std::hypot(1.0, std::hypot(pose.slope_x, pose.slope_y));
    const double measured = range.Distance(bin.range_mm);
    const Eigen::Vector3d from =
        beam.ray.origin + measured * beam.ray.direction - Eigen::Vector3d(pose.x, pose.y, pose.z);
    row.residual = along.dot(from) - target.edges_mm[static_cast<std::size_t>(bin.edge)];
    FollowBeam(setup, bin, beam, measured, along, row);
    FollowRange(setup, placement, bin.range_mm, along.dot(beam.ray.direction), row);
    row.by_pose << -along.x(), -along.y(), (from.x() - along.dot(from) * along.x()) / steep,
        (from.y() - along.dot(from) * along.y()) / steep, 0.0, -along.z();
    row.by_knot = (1.0 - above) * along.head<2>().transpose();
    row.by_next_knot = above * along.head<2>().transpose();
    row.distance = measured;
    row.cos_incidence = 1.0;
    Divide(row, bin.edge_sigma_mm);
    return true;
  }
  const auto hit = MeetTarget(target, form, pose, beam.ray);
  if (!hit) return false;
  const Eigen::Vector3d g = hit->gradient / hit->gradient.dot(beam.ray.direction);  // minus it: expected distance
  // The reading is compared, not the distance made of it: noise that went into scale and quadratic terms would bias
  // them (errors in variables), the same way for all sensors. It is put into mm of distance by the starting slope,
  // which is a constant: with the solved one, a smaller scale would seem to make all residuals smaller.
  const double reading = range.ReadingOf(hit->distance);
  const double slope = range.range_scale + 2.0 * range.range_quadratic * reading;
  if (!(slope > 0.5)) return false;  // also if there is no such reading
  const SensorCalibration& first = setup.start.sensors[bin.sensor];
  const double first_slope = first.range_scale + 2.0 * first.range_quadratic * bin.range_mm;
  const double share = first_slope / slope;
  row.residual = first_slope * (bin.range_mm - reading);
  const Eigen::Vector3d by_place = share * g;
  FollowBeam(setup, bin, beam, hit->distance, by_place, row);
  FollowRange(setup, placement, reading, share, row);
  row.by_pose = -share * DistanceByPose(target, form, pose, beam.ray, *hit).transpose();
  row.by_form = -share * DistanceByForm(target, beam.ray, *hit).transpose();
  ScaleTaper(row);
  row.by_knot = (1.0 - above) * by_place.head<2>().transpose();
  row.by_next_knot = above * by_place.head<2>().transpose();
  row.distance = hit->distance;
  row.cos_incidence = hit->cos_incidence;
  row.phi = hit->phi;
  // Readings of one bin have errors in common that their number does not average away (rounding, the bin's curvature).
  constexpr double kBinFloor = 0.02;  // mm
  Divide(row, std::hypot(setup.noise_mm / std::sqrt(bin.weight), kBinFloor));
  return true;
}

bool EvaluateBin(const CalibrationSetup& setup, const CalibrationState& state, std::size_t placement,
                 const TargetBin& bin, BinRow& row) {
  const std::size_t knot = KnotAt(state.ring.knots_z_mm, setup.start.carriage.position_scale * bin.z_mm).first;
  const BinUnknowns unknowns{state.ring.sensors[bin.sensor].data(), state.ring.ring.data(),
                             state.poses[placement].data(),         state.forms[setup.scans[placement].target].data(),
                             state.ring.path[knot].data(),          state.ring.path[knot + 1].data()};
  return EvaluateBin(setup, placement, bin, state.ring.knots_z_mm, unknowns, row);
}

}  // namespace annulus
