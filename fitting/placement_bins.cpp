#include "fitting/placement_bins.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include "base/frames.h"
#include "fitting/placement_pose.h"

namespace annulus {
namespace {

using Kind = CalibrationTarget::Kind;

constexpr double kNearby = 15.0;    // mm: further from the target's surface is something else
constexpr double kEdgeZone = 14.0;  // mm about an edge in which a beam that is aimed 1 degree wrong may see either step
constexpr double kWild = 4.0;       // sd
constexpr double kWildFloor = 1.0;  // mm
constexpr std::size_t kFewestInBin = 3;
constexpr std::size_t kFewestBins = 40;

/// A reading beside what the pose says of it.
struct Seen {
  const TargetReading* reading;
  double residual;  ///< Measured less expected distance, mm.
  double along;     ///< mm from the pose's point.
};

double MiddleOf(std::vector<double>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

bool NearEdge(const CalibrationTarget& target, double along) {
  if (target.kind != Kind::kStep) return false;
  return std::any_of(target.edges_mm.begin(), target.edges_mm.end(),
                     [&](double edge) { return std::abs(along - edge) < kEdgeZone; });
}

/// Puts one bin's readings together; nothing if too few are left.
class BinMaker {
 public:
  BinMaker(const RingCalibration& start, const PlacedTarget& placed, PlacementBins& result)
      : start_(start), placed_(placed), result_(result) {}

  void Add(std::vector<Seen>& seen) {
    if (seen.size() < kFewestInBin) return;
    std::vector<double> values;
    for (const Seen& one : seen) values.push_back(one.residual);
    const double middle = MiddleOf(values);
    for (double& value : values) value = std::abs(value - middle);
    const double limit = std::max(kWildFloor, kWild * 1.4826 * MiddleOf(values));
    double weight = 0.0;
    double mean = 0.0;
    double height = 0.0;
    std::uint32_t count = 0;
    for (const Seen& one : seen) {
      if (std::abs(one.residual - middle) > limit) continue;
      const double w = one.reading->weight;
      weight += w;
      mean += w * one.residual;
      height += w * one.reading->z_mm;
      ++count;
    }
    result_.rejected += seen.size() - count;
    if (count < kFewestInBin || !(weight > 0.0)) return;
    mean /= weight;
    height /= weight;
    for (const Seen& one : seen) {
      if (std::abs(one.residual - middle) > limit) continue;
      squares_ += one.reading->weight * (one.residual - mean) * (one.residual - mean);
    }
    freedom_ += count - 1.0;
    const std::uint16_t sensor = seen.front().reading->sensor;
    const auto hit = placed_.Meet(start_.RayOf(sensor, height));
    if (!hit) return;
    const double range = start_.sensors[sensor].ReadingOf(hit->distance + mean);
    if (!std::isfinite(range)) return;
    result_.bins.push_back({sensor, height, range, weight, count, -1, 0.0});
    result_.readings += count;
  }

  [[nodiscard]] double Noise() const { return freedom_ > 0.0 ? std::sqrt(squares_ / freedom_) : 0.0; }

 private:
  const RingCalibration& start_;
  const PlacedTarget& placed_;
  PlacementBins& result_;
  double squares_ = 0.0;
  double freedom_ = 0.0;
};

/// A step target's column as if it were round, half-way between both steps.
CalibrationTarget RoundColumn(const CalibrationTarget& target) {
  CalibrationTarget round = target;
  round.kind = Kind::kCylinder;
  return round;
}

TargetForm MiddleForm(const PlacedTarget& placed) {
  TargetForm form = placed.form;
  form.radius_mm += 0.5 * placed.target.step_mm;
  return form;
}

/// A reading near an edge: reported height, and how far behind the middle of both steps it seems to be.
struct NearStep {
  double z, behind;
};

/// Where along the heights one level of a step goes over into the other: the cut with the least squares about both
/// means. A sensor's own offset and its aim do not matter so.
struct StepCut {
  std::size_t cut = 0;  ///< Readings below it.
  double rise = 0.0;    ///< Mean above less mean below, mm.
};

std::optional<StepCut> CutOf(const std::vector<NearStep>& near) {
  constexpr std::size_t kFewest = 2;
  double all = 0.0;
  for (const NearStep& one : near) all += one.behind;
  double below = 0.0;
  double best = 0.0;
  StepCut found;
  for (std::size_t c = 1; c < near.size(); ++c) {
    below += near[c - 1].behind;
    if (c < kFewest || c + kFewest > near.size()) continue;
    const auto low = static_cast<double>(c);
    const auto high = static_cast<double>(near.size() - c);
    const double rise = (all - below) / high - below / low;
    const double gain = rise * rise * low * high / (low + high);
    if (gain <= best) continue;
    best = gain;
    found = {c, rise};
  }
  if (found.cut == 0) return std::nullopt;
  return found;
}

/// Heights at which a sensor's beam passes an edge.
void AddCrossings(const RingCalibration& start, const PlacedTarget& placed, const std::vector<Seen>& seen,
                  PlacementBins& result) {
  constexpr double kZone = 2.0 * kEdgeZone;
  const CalibrationTarget round = RoundColumn(placed.target);
  const TargetForm middle = MiddleForm(placed);
  for (std::size_t k = 0; k < placed.target.edges_mm.size(); ++k) {
    std::vector<NearStep> near;
    for (const Seen& one : seen) {
      if (std::abs(one.along - placed.target.edges_mm[k]) > kZone) continue;
      const TargetReading& reading = *one.reading;
      const auto hit = MeetTarget(round, middle, placed.pose, start.RayOf(reading.sensor, reading.z_mm));
      if (!hit) continue;
      near.push_back({reading.z_mm, start.sensors[reading.sensor].Distance(reading.range_mm) - hit->distance});
    }
    std::sort(near.begin(), near.end(), [](const NearStep& a, const NearStep& b) { return a.z < b.z; });
    const auto cut = CutOf(near);
    // A column that grows wider comes nearer.
    const double expected = (k % 2 == 0 ? -1.0 : 1.0) * placed.target.step_mm;
    if (!cut || std::abs(cut->rise - expected) > 0.4 * placed.target.step_mm) continue;
    TargetBin bin;
    bin.sensor = seen.front().reading->sensor;
    bin.z_mm = 0.5 * (near[cut->cut - 1].z + near[cut->cut].z);
    const auto hit = MeetTarget(round, middle, placed.pose, start.RayOf(bin.sensor, bin.z_mm));
    if (!hit) continue;
    bin.range_mm = start.sensors[bin.sensor].ReadingOf(hit->distance);
    bin.weight = 1.0;
    bin.readings = static_cast<std::uint32_t>(near.size());
    bin.edge = static_cast<int>(k);
    // Anywhere between two levels; and the spot is not a point.
    bin.edge_sigma_mm = std::max(0.3, (near[cut->cut].z - near[cut->cut - 1].z) / std::sqrt(12.0));
    result.bins.push_back(bin);
  }
}

/// How far apart two sweeps see the target, by height. A sensor's own errors are the same in both.
TargetMotion MotionBetweenSweeps(const RingCalibration& start, const std::vector<std::vector<Seen>>& by_sensor,
                                 double noise) {
  constexpr double kSlice = 60.0;  // mm
  struct Sums {
    double residual = 0.0, weight = 0.0;
  };
  std::map<std::pair<int, std::uint16_t>, std::vector<Sums>> slices;  // (slice, sweep) -> by sensor
  for (std::size_t sensor = 0; sensor < by_sensor.size(); ++sensor) {
    for (const Seen& one : by_sensor[sensor]) {
      const auto slice = static_cast<int>(std::floor(one.reading->z_mm / kSlice));
      auto& sums = slices[{slice, one.reading->sweep}];
      if (sums.empty()) sums.resize(by_sensor.size());
      if (std::abs(one.residual) > kNearby) continue;
      sums[sensor].residual += one.reading->weight * one.residual;
      sums[sensor].weight += one.reading->weight;
    }
  }
  TargetMotion motion;
  for (auto first = slices.begin(); first != slices.end(); ++first) {
    for (auto second = std::next(first); second != slices.end() && second->first.first == first->first.first;
         ++second) {
      Eigen::Matrix2d normal = Eigen::Matrix2d::Zero();
      Eigen::Vector2d right = Eigen::Vector2d::Zero();
      for (std::size_t sensor = 0; sensor < by_sensor.size(); ++sensor) {
        const Sums& a = first->second[sensor];
        const Sums& b = second->second[sensor];
        if (a.weight < 1.0 || b.weight < 1.0) continue;
        // A target that moves towards the sensor's side shortens its distance.
        const Eigen::Vector2d towards(-std::cos(start.sensors[sensor].theta), -std::sin(start.sensors[sensor].theta));
        const double weight = 1.0 / (noise * noise * (1.0 / a.weight + 1.0 / b.weight));
        normal += weight * towards * towards.transpose();
        right += weight * (b.residual / b.weight - a.residual / a.weight) * towards;
      }
      if (!(normal.determinant() > 1e-6)) continue;
      const Eigen::Vector2d shift = normal.ldlt().solve(right);
      const double sigma = std::sqrt(normal.inverse().trace() / 2.0);
      motion.seen = true;
      if (shift.norm() > motion.largest_mm) {
        motion.largest_mm = shift.norm();
        motion.sigma_mm = sigma;
      }
    }
  }
  return motion;
}

/// The readings of the target, by sensor; counts the others.
std::vector<std::vector<Seen>> SeenOf(const RingCalibration& start, const PlacedTarget& placed, const TargetScan& scan,
                                      PlacementBins& result) {
  const CalibrationTarget& target = placed.target;
  const CalibrationTarget round = RoundColumn(target);
  const TargetForm middle = MiddleForm(placed);
  std::vector<std::vector<Seen>> by_sensor(start.sensors.size());
  result.z_low = 1e9;
  result.z_high = -1e9;
  const double reach = kNearby + (target.kind == Kind::kStep ? target.step_mm : 0.0);
  for (const TargetReading& reading : scan.readings) {
    if (!IsReading(start, reading)) continue;
    const Ray ray = start.RayOf(reading.sensor, reading.z_mm);
    auto hit = placed.Meet(ray);
    if (target.kind == Kind::kStep) {
      // A beam that is aimed a little wrong may pass an edge: its reading counts on either step.
      const auto between = MeetTarget(round, middle, placed.pose, ray);
      if (between && NearEdge(target, between->along)) hit = between;
    }
    const double distance = start.sensors[reading.sensor].Distance(reading.range_mm);
    if (!hit || std::abs(distance - hit->distance) > reach || hit->cos_incidence < 0.35) {
      ++result.elsewhere;
      continue;
    }
    by_sensor[reading.sensor].push_back({&reading, distance - hit->distance, hit->along});
    result.z_low = std::min(result.z_low, reading.z_mm);
    result.z_high = std::max(result.z_high, reading.z_mm);
  }
  return by_sensor;
}

}  // namespace

Result<PlacementBins> PreparePlacement(const RingCalibration& start, const CalibrationTarget& target,
                                       const TargetScan& scan, double bin_mm) {
  const auto placed = FindPose(start, target, scan);
  if (!placed) return Fail(placed);
  PlacementBins result;
  result.pose = placed->pose;
  std::vector<std::vector<Seen>> by_sensor = SeenOf(start, *placed, scan, result);
  BinMaker maker(start, *placed, result);
  std::vector<std::vector<Seen>> in_bin;
  for (std::vector<Seen>& seen : by_sensor) {
    in_bin.assign(static_cast<std::size_t>(std::max(0.0, result.z_high - result.z_low) / bin_mm) + 1, {});
    for (const Seen& one : seen) {
      if (NearEdge(target, one.along)) continue;
      in_bin[static_cast<std::size_t>((one.reading->z_mm - result.z_low) / bin_mm)].push_back(one);
    }
    for (std::vector<Seen>& bin : in_bin) maker.Add(bin);
    if (target.kind == Kind::kStep && !seen.empty()) AddCrossings(start, *placed, seen, result);
  }
  result.noise_mm = maker.Noise();
  if (result.bins.size() < kFewestBins) {
    return Fail("find the target in " + scan.name,
                "only " + std::to_string(result.bins.size()) + " places of it were seen well enough",
                "stand the target into the ring's middle and scan again; check its radius");
  }
  if (target.kind != Kind::kPlane) {
    result.motion = MotionBetweenSweeps(start, by_sensor, std::max(result.noise_mm, 1e-3));
  }
  return result;
}

}  // namespace annulus
