#include "fitting/placement_pose.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <map>

namespace annulus {
namespace {

using Kind = CalibrationTarget::Kind;
using Vector7 = Eigen::Matrix<double, 7, 1>;  // the pose, then the radius

constexpr std::size_t kFewestPoints = 24;  // of a section
constexpr std::size_t kFewestSections = 3;
constexpr double kBoardThickness = 18.0;  // mm, to begin with

/// A circle through the points of one level, by Kasa's algebraic fit (1976).
struct Section {
  double z = 0.0, radius = 0.0;
  Eigen::Vector2d centre;
};

std::optional<Section> CircleOf(const std::vector<Eigen::Vector3d>& points) {
  if (points.size() < kFewestPoints) return std::nullopt;
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  Section section;
  for (const Eigen::Vector3d& p : points) {
    const Eigen::Vector3d row(p.x(), p.y(), 1.0);
    normal += row * row.transpose();
    right += p.head<2>().squaredNorm() * row;
    section.z += p.z() / static_cast<double>(points.size());
  }
  const Eigen::LDLT<Eigen::Matrix3d> factors(normal);
  if (factors.info() != Eigen::Success || !(factors.rcond() > 1e-12)) return std::nullopt;
  const Eigen::Vector3d found = factors.solve(right);
  section.centre = 0.5 * found.head<2>();
  const double square = found.z() + section.centre.squaredNorm();
  if (!(square > 0.0)) return std::nullopt;
  section.radius = std::sqrt(square);
  return section;
}

/// The circle again without points that are far from it.
std::optional<Section> SectionOf(std::vector<Eigen::Vector3d> points) {
  std::optional<Section> section = CircleOf(points);
  for (int round = 0; round < 3 && section; ++round) {
    std::vector<double> misses;
    for (const Eigen::Vector3d& p : points) {
      misses.push_back(std::abs((p.head<2>() - section->centre).norm() - section->radius));
    }
    std::vector<double> sorted = misses;
    const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
    std::nth_element(sorted.begin(), middle, sorted.end());
    const double limit = std::max(3.0, 5.0 * *middle);
    std::vector<Eigen::Vector3d> kept;
    for (std::size_t k = 0; k < points.size(); ++k) {
      if (misses[k] < limit) kept.push_back(points[k]);
    }
    if (kept.size() == points.size()) break;
    points = std::move(kept);
    section = CircleOf(points);
  }
  return section;
}

struct Cloud {
  std::vector<Eigen::Vector3d> points;
  std::vector<Section> sections;
};

Cloud CloudOf(const RingCalibration& start, const TargetScan& scan) {
  constexpr double kLevel = 2.0;  // mm
  std::map<std::pair<int, int>, std::vector<Eigen::Vector3d>> levels;
  Cloud cloud;
  for (const TargetReading& reading : scan.readings) {
    if (!IsReading(start, reading)) continue;
    const Eigen::Vector3d point = start.PointOf(reading.sensor, reading.z_mm, reading.range_mm);
    const Eigen::Vector3d outward = PointFromCylindrical(start.sensors[reading.sensor].theta, 1.0, 0.0);
    if (point.dot(outward) < -300.0) continue;  // far beyond the axis: nothing of a target
    cloud.points.push_back(point);
    levels[{reading.sweep, static_cast<int>(std::floor(reading.z_mm / kLevel))}].push_back(point);
  }
  for (const auto& [key, points] : levels) {
    if (const auto section = SectionOf(points)) cloud.sections.push_back(*section);
  }
  return cloud;
}

/// Sections whose radius is that of a column; sorted by height.
std::vector<Section> ColumnSections(const Cloud& cloud, const CalibrationTarget& target) {
  std::vector<Section> column;
  const double wide = target.radius_mm + (target.kind == Kind::kStep ? target.step_mm : 0.0);
  for (const Section& section : cloud.sections) {
    // A tilt of 15 degrees makes an ellipse that is 3.5 % longer.
    if (section.radius > 0.93 * target.radius_mm - 6.0 && section.radius < 1.07 * wide + 6.0) column.push_back(section);
  }
  std::sort(column.begin(), column.end(), [](const Section& a, const Section& b) { return a.z < b.z; });
  return column;
}

std::optional<TargetPose> ColumnPose(const Cloud& cloud, const CalibrationTarget& target) {
  const std::vector<Section> column = ColumnSections(cloud, target);
  if (column.size() < kFewestSections) return std::nullopt;
  double middle = 0.0;
  for (const Section& section : column) middle += section.z / static_cast<double>(column.size());
  // A line through the centres, far ones counting less (Cauchy).
  Eigen::Matrix2d line = Eigen::Matrix2d::Zero();  // rows x, y: value at the middle, slope
  for (int round = 0; round < 12; ++round) {
    Eigen::Matrix2d normal = 1e-9 * Eigen::Matrix2d::Identity();
    Eigen::Matrix2d right = Eigen::Matrix2d::Zero();
    for (const Section& section : column) {
      const Eigen::Vector2d row(1.0, section.z - middle);
      const double miss = round == 0 ? 0.0 : (section.centre - line * row).norm();
      const double weight = 1.0 / (1.0 + miss * miss);
      normal += weight * row * row.transpose();
      right += weight * section.centre * row.transpose();
    }
    if (!(std::abs(normal.determinant()) > 0.0)) return std::nullopt;
    line = right * normal.inverse();
  }
  TargetPose pose;
  pose.x = line(0, 0);
  pose.y = line(1, 0);
  pose.z = middle;
  pose.slope_x = line(0, 1);
  pose.slope_y = line(1, 1);
  if (target.kind == Kind::kStep) {
    // The foot: the heights of the edges are over it. The lowest section seen stands near it.
    const double foot = column.front().z;
    pose.x += (foot - middle) * pose.slope_x;
    pose.y += (foot - middle) * pose.slope_y;
    pose.z = foot;
  }
  return pose;
}

std::optional<TargetPose> SpherePose(const Cloud& cloud, const CalibrationTarget& target) {
  // r^2 = R^2 - (z - z_c)^2 is linear in z after adding z^2: the mean over pairs is robust enough for a start.
  const Section* widest = nullptr;
  for (const Section& section : cloud.sections) {
    if (section.radius > 1.05 * target.radius_mm + 3.0) continue;
    if (widest == nullptr || section.radius > widest->radius) widest = &section;
  }
  if (widest == nullptr || widest->radius < 0.6 * target.radius_mm) return std::nullopt;
  TargetPose pose;
  pose.x = widest->centre.x();
  pose.y = widest->centre.y();
  double sum = 0.0;
  double weight = 0.0;
  for (const Section& section : cloud.sections) {
    if ((section.centre - widest->centre).norm() > 5.0 || section.radius < 0.5 * target.radius_mm) continue;
    sum += section.z;
    weight += 1.0;
  }
  pose.z = weight > 0.0 ? sum / weight : widest->z;
  return pose;
}

std::optional<TargetPose> PlanePose(const Cloud& cloud) {
  if (cloud.points.size() < 100) return std::nullopt;
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& p : cloud.points) mean += p / static_cast<double>(cloud.points.size());
  Eigen::Matrix2d spread = Eigen::Matrix2d::Zero();
  for (const Eigen::Vector3d& p : cloud.points) {
    const Eigen::Vector2d d = (p - mean).head<2>();
    spread += d * d.transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(spread);
  const Eigen::Vector2d normal = axes.eigenvectors().col(0);
  TargetPose pose;
  pose.x = mean.x();
  pose.y = mean.y();
  pose.z = mean.z();
  pose.turn = std::atan2(normal.y(), normal.x());
  return pose;
}

/// A reading as the starting calibration has it.
struct Sight {
  Ray ray;
  double distance = 0.0, weight = 1.0;
};

/// Every so many readings, so that there are `most` at most.
std::vector<Sight> SightsOf(const RingCalibration& start, const TargetScan& scan, std::size_t most) {
  std::vector<Sight> sights;
  const std::size_t stride = std::max<std::size_t>(1, scan.readings.size() / most);
  for (std::size_t k = 0; k < scan.readings.size(); k += stride) {
    const TargetReading& reading = scan.readings[k];
    if (!IsReading(start, reading)) continue;
    sights.push_back({start.RayOf(reading.sensor, reading.z_mm),
                      start.sensors[reading.sensor].Distance(reading.range_mm), reading.weight});
  }
  return sights;
}

/// Normal equations of the distances by pose and thickness, wild ones counting less (Cauchy).
struct PoseNormal {
  Eigen::Matrix<double, 7, 7> matrix = Eigen::Matrix<double, 7, 7>::Zero();
  Vector7 right = Vector7::Zero();
  std::size_t used = 0;
};

PoseNormal NormalOf(const std::vector<Sight>& sights, const PlacedTarget& placed, double scale) {
  const std::array<bool, 6> freedom = PoseFreedom(placed.target.kind);
  PoseNormal normal;
  for (const Sight& sight : sights) {
    const auto hit = placed.Meet(sight.ray);
    if (!hit || hit->cos_incidence < 0.25) continue;
    const double miss = sight.distance - hit->distance;
    if (std::abs(miss) > 5.0 * scale) continue;
    const double weight = sight.weight / (1.0 + miss * miss / (scale * scale));
    Vector7 by;
    by << DistanceByPose(placed.target, placed.form, placed.pose, sight.ray, *hit),
        DistanceByForm(placed.target, sight.ray, *hit)[0];
    for (Eigen::Index c = 0; c < 6; ++c) {
      if (!freedom[static_cast<std::size_t>(c)]) by[c] = 0.0;
    }
    if (placed.target.kind != Kind::kPlane) by[6] = 0.0;
    normal.matrix += weight * by * by.transpose();
    normal.right += weight * miss * by;
    ++normal.used;
  }
  for (Eigen::Index c = 0; c < 7; ++c) normal.matrix(c, c) += 1e-6 * normal.matrix(c, c) + 1e-9;
  return normal;
}

/// Robust least squares of the distances by pose and, of a plane, thickness. True if it settled on enough readings.
bool Refine(const RingCalibration& start, const TargetScan& scan, PlacedTarget& placed) {
  constexpr std::size_t kMost = 12'000;
  constexpr int kRounds = 20;
  const std::vector<Sight> sights = SightsOf(start, scan, kMost);
  double scale = 20.0;  // mm
  for (int round = 0; round < kRounds; ++round) {
    const PoseNormal normal = NormalOf(sights, placed, scale);
    if (normal.used < kFewestPoints) return false;
    const Vector7 change = normal.matrix.ldlt().solve(normal.right);
    if (!change.allFinite()) return false;
    placed.pose.x += change[0];
    placed.pose.y += change[1];
    placed.pose.slope_x += change[2];
    placed.pose.slope_y += change[3];
    placed.pose.turn += change[4];
    placed.pose.z += change[5];
    placed.form.radius_mm += change[6];
    scale = std::max(2.0, 0.6 * scale);
    if (scale == 2.0 && change.head<2>().norm() < 1e-3) break;
  }
  return true;
}

/// The foot of a step target: edges are where the radius changes. Tried over all offsets that fit into what was seen.
void FindFoot(const RingCalibration& start, const TargetScan& scan, PlacedTarget& placed) {
  constexpr double kTry = 4.0;  // mm
  const CalibrationTarget& target = placed.target;
  if (target.edges_mm.empty()) return;
  const TargetPose first = placed.pose;
  TargetPose best = first;
  double least = std::numeric_limits<double>::infinity();
  const std::vector<Sight> sights = SightsOf(start, scan, 6'000);
  for (double down = -target.edges_mm.back() - 100.0; down <= target.height_mm; down += kTry) {
    TargetPose pose = first;
    pose.z += down;
    pose.x += down * first.slope_x;
    pose.y += down * first.slope_y;
    double cost = 0.0;
    for (const Sight& sight : sights) {
      const auto hit = MeetTarget(target, placed.form, pose, sight.ray);
      const double miss = hit ? sight.distance - hit->distance : target.step_mm;
      cost += std::min(std::abs(miss), 2.0 * target.step_mm);
    }
    if (cost < least) {
      least = cost;
      best = pose;
    }
  }
  placed.pose = best;
}

}  // namespace

bool IsReading(const RingCalibration& ring, const TargetReading& reading) {
  constexpr double kFarthest = 1e5;  // mm
  return reading.sensor < ring.sensors.size() && reading.range_mm > 0.0 && reading.range_mm < kFarthest &&
         std::abs(reading.z_mm) < kFarthest && reading.weight > 0.0F && std::isfinite(reading.weight);
}

std::array<bool, 6> PoseFreedom(CalibrationTarget::Kind kind) {
  switch (kind) {
    case Kind::kSphere:
      return {true, true, false, false, false, true};
    case Kind::kPlane:
      return {true, true, true, false, true, false};
    case Kind::kStep:
    case Kind::kCylinder:
      break;
  }
  return {true, true, true, true, false, false};
}

Result<PlacedTarget> FindPose(const RingCalibration& start, const CalibrationTarget& target, const TargetScan& scan) {
  const Cloud cloud = CloudOf(start, scan);
  std::optional<TargetPose> pose;
  switch (target.kind) {
    case Kind::kSphere:
      pose = SpherePose(cloud, target);
      break;
    case Kind::kPlane:
      pose = PlanePose(cloud);
      break;
    case Kind::kStep:
    case Kind::kCylinder:
      pose = ColumnPose(cloud, target);
      break;
  }
  const std::string attempted = "find the target in " + scan.name;
  const std::string advice = "stand the target into the ring and nothing else, check its kind and radius, scan again";
  if (!pose) return Fail(attempted, "nothing of its shape and size was seen", advice);
  PlacedTarget placed{target, {}, *pose};
  placed.form.radius_mm = target.kind == Kind::kPlane
                              ? 0.5 * kBoardThickness
                              : target.RadiusAt(scan.temperature_c.value_or(target.certified_c));
  if (target.kind == Kind::kStep) FindFoot(start, scan, placed);
  if (!Refine(start, scan, placed)) return Fail(attempted, "no place of it agrees with the readings", advice);
  if (target.kind != Kind::kPlane && scan.turn) placed.pose.turn = *scan.turn;
  return placed;
}

}  // namespace annulus
