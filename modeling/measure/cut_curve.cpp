#include "modeling/measure/cut_curve.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>

#include "base/frames.h"
#include "modeling/measure/gauss.h"

namespace annulus {
namespace {

constexpr double kOnPlane = 1e-10;      // mm: a point at this height is on the plane
constexpr double kTouching = 1e-7;      // sine of the angle between plane and surface at which they touch
constexpr double kLargestTurn = 0.15;   // rad, between nodes
constexpr double kShortestStep = 1e-7;  // mm
constexpr double kLongestStep = 2.0;    // mm
constexpr double kLargestSag = 0.03;    // of a chord: how far a target may be beside it
constexpr double kNearestNodes = 0.01;  // mm
constexpr std::size_t kMostNodes = 200'000;

/// The plane's height over the surface at one place: g(theta, z) = n · P(theta, z) - d.
struct HeightJet {
  double value = 0.0;     // mm
  double by_theta = 0.0;  // mm/rad
  double by_z = 0.0;      // mm/mm
  RadiusJet radius;
  Eigen::Vector3d p;        // P
  Eigen::Vector3d p_theta;  // ∂P/∂theta
  Eigen::Vector3d p_z;      // ∂P/∂z
};

HeightJet HeightAt(const SplineSurface& surface, const CuttingPlane& plane, double theta, double z) {
  HeightJet h;
  h.radius = surface.Jet(theta, z);
  const double cosine = std::cos(theta);
  const double sine = std::sin(theta);
  h.p = {h.radius.r * cosine, h.radius.r * sine, z};
  h.p_theta = {h.radius.r_theta * cosine - h.radius.r * sine, h.radius.r_theta * sine + h.radius.r * cosine, 0.0};
  h.p_z = {h.radius.r_z * cosine, h.radius.r_z * sine, 1.0};
  h.value = plane.Height(h.p);
  h.by_theta = plane.normal.dot(h.p_theta);
  h.by_z = plane.normal.dot(h.p_z);
  return h;
}

/// The first fundamental form of the surface.
struct Metric {
  double theta_theta = 0.0;
  double theta_z = 0.0;
  double z_z = 0.0;

  explicit Metric(const HeightJet& h)
      : theta_theta(h.p_theta.squaredNorm()), theta_z(h.p_theta.dot(h.p_z)), z_z(h.p_z.squaredNorm()) {}
  [[nodiscard]] double Determinant() const { return theta_theta * z_z - theta_z * theta_z; }
  [[nodiscard]] double Length(const Eigen::Vector2d& v) const {
    return std::sqrt(theta_theta * v.x() * v.x() + 2.0 * theta_z * v.x() * v.y() + z_z * v.y() * v.y());
  }
  /// The steepest direction of g on the surface: metric⁻¹ ∇g times the determinant.
  [[nodiscard]] Eigen::Vector2d Steepest(const HeightJet& h) const {
    return {z_z * h.by_theta - theta_z * h.by_z, theta_theta * h.by_z - theta_z * h.by_theta};
  }
};

/// Knot lines strictly between two places, in the order in which they are met: theta lines by their number, z lines by
/// their height.
std::vector<double> LinesBetween(double from, double to, double spacing) {
  std::vector<double> lines;
  const double low = std::min(from, to);
  const double high = std::max(from, to);
  for (double i = std::floor(low / spacing) + 1.0; i * spacing < high; i += 1.0) {
    if (i * spacing > low) lines.push_back(i * spacing);
  }
  return lines;
}

std::vector<double> LinesBetween(double from, double to, std::span<const double> breaks) {
  const auto first = std::upper_bound(breaks.begin(), breaks.end(), std::min(from, to));
  const auto last = std::lower_bound(first, breaks.end(), std::max(from, to));
  return {first, last};
}

const std::vector<QuadratureNode>& UnitGauss() {
  static const std::vector<QuadratureNode> kNodes = PiecewiseGauss(std::array<double, 2>{0.0, 1.0});
  return kNodes;
}

/// A coordinate along a piece, and its derivative.
struct Along {
  double value = 0.0;
  double by_t = 0.0;
};

/// Where along a piece (t = 0 … 1) one of its coordinates, `from` at 0 and `to` at 1, takes `value` between them:
/// safeguarded Newton.
template <class Evaluate>
double FindAlong(double from, double to, double value, const Evaluate& at) {
  double low = 0.0;
  double high = 1.0;
  double t = (value - from) / (to - from);
  for (int k = 0; k < 60; ++k) {
    const Along x = at(t);
    const double miss = x.value - value;
    if (std::abs(miss) <= 1e-13 * (std::abs(value) + 1.0)) break;
    ((miss > 0.0) == (to > from) ? high : low) = t;
    const double next = x.by_t != 0.0 ? t - miss / x.by_t : low;
    const double step = next > low && next < high ? next : 0.5 * (low + high);
    if (std::abs(step - t) < 1e-15) break;
    t = step;
  }
  return t;
}

/// Where a target lies on the chord of a piece, 0 … 1; nothing if it is not on the piece.
std::optional<double> Meets(const CutNode& from, const CutNode& to, const SurfacePlace& target,
                            const Eigen::Vector3d& position) {
  const Eigen::Vector3d chord = to.position - from.position;
  const double length = chord.norm();
  if (length == 0.0) return std::nullopt;
  const double u = (position - from.position).dot(chord) / (length * length);
  if (!(u >= -1e-9 && u <= 1.0 + 1e-9)) return std::nullopt;
  const double beside = (position - from.position - u * chord).norm();
  if (beside > kLargestSag * length + 1e-7) return std::nullopt;
  // The same place, not only the same point of a surface that comes near itself.
  const double theta = AngleDifference(target.theta, from.theta) - u * (to.theta - from.theta);
  const double z = target.z - from.z - u * (to.z - from.z);
  const double wide = 0.2 * std::abs(to.theta - from.theta) + 2.0 * std::abs(from.across_theta) * length;
  const double high = 0.2 * std::abs(to.z - from.z) + 2.0 * std::abs(from.across_z) * length;
  if (std::abs(theta) > wide + 1e-9 || std::abs(z) > high + 1e-7) return std::nullopt;
  return u;
}

/// Without inner nodes that all but coincide with their neighbours: a direction between them would be noise.
std::vector<CutNode> Thinned(const std::vector<CutNode>& nodes) {
  std::vector<CutNode> kept{nodes.front()};
  for (std::size_t k = 1; k + 1 < nodes.size(); ++k) {
    const Eigen::Vector3d& p = nodes[k].position;
    const bool apart = (p - kept.back().position).norm() > kNearestNodes;
    if (apart && (p - nodes.back().position).norm() > kNearestNodes) kept.push_back(nodes[k]);
  }
  kept.push_back(nodes.back());
  return kept;
}

}  // namespace

std::optional<CutNode> CutCurve::NodeAt(double theta, double z, double sign) const {
  const HeightJet h = HeightAt(*surface_, plane_, theta, z);
  const Metric metric(h);
  const Eigen::Vector2d along = sign * Eigen::Vector2d(h.by_z, -h.by_theta);
  const Eigen::Vector2d across = metric.Steepest(h);
  const double speed = metric.Length(along);  // |n × N| for the surface's normal N of length sqrt(determinant)
  const double area = std::sqrt(std::max(metric.Determinant(), 0.0));
  if (!(speed > kTouching * area) || !(area > 0.0)) return std::nullopt;
  CutNode node;
  node.theta = theta;
  node.z = z;
  node.along_theta = along.x() / speed;
  node.along_z = along.y() / speed;
  const double width = metric.Length(across);
  node.across_theta = across.x() / width;
  node.across_z = across.y() / width;
  node.position = h.p;
  node.tangent = (node.along_theta * h.p_theta + node.along_z * h.p_z).normalized();
  return node;
}

double CutCurve::LongestStep(const CutNode& node) const {
  const std::vector<double>& breaks = surface_->z_basis().breakpoints();
  const std::size_t j = surface_->z_basis().Interval(node.z);
  const double by_theta = surface_->theta_basis().spacing() / std::max(std::abs(node.along_theta), 1e-12);
  const double by_z = (breaks[j + 1] - breaks[j]) / std::max(std::abs(node.along_z), 1e-12);
  return std::min({by_theta, by_z, kLongestStep});
}

std::optional<CutNode> CutCurve::Step(const CutNode& from, double length, double sign) const {
  double theta = from.theta + length * from.along_theta;
  double z = from.z + length * from.along_z;
  bool on_plane = false;
  for (int k = 0; k < 8 && !on_plane; ++k) {
    const HeightJet h = HeightAt(*surface_, plane_, theta, z);
    if (!std::isfinite(h.value)) return std::nullopt;
    on_plane = std::abs(h.value) < kOnPlane;
    const Eigen::Vector2d steepest = Metric(h).Steepest(h);
    const double slope = h.by_theta * steepest.x() + h.by_z * steepest.y();
    if (on_plane || !(slope > 0.0)) break;
    theta -= h.value / slope * steepest.x();
    z -= h.value / slope * steepest.y();
  }
  if (!on_plane) return std::nullopt;
  const auto to = NodeAt(theta, z, sign);
  if (!to) return std::nullopt;
  const Eigen::Vector3d chord = to->position - from.position;
  const double distance = chord.norm();
  // Neighbouring branches of the curve run the opposite way: a step that jumps to one turns around.
  const bool smooth = from.tangent.cross(to->tangent).norm() < std::sin(kLargestTurn) &&
                      from.tangent.dot(to->tangent) > 0.0 && chord.dot(from.tangent) > 0.98 * distance &&
                      distance > 0.5 * length && distance < 1.5 * length;
  return smooth ? to : std::nullopt;
}

CutSample CutCurve::Between(const CutNode& from, const CutNode& to, double t) const {
  const double step_theta = to.theta - from.theta;
  const double step_z = to.z - from.z;
  double theta = from.theta + t * step_theta;
  double z = from.z + t * step_z;
  HeightJet h = HeightAt(*surface_, plane_, theta, z);
  for (int k = 0; k < 8 && std::abs(h.value) > kOnPlane; ++k) {
    const double slope = h.by_theta * from.across_theta + h.by_z * from.across_z;
    if (slope == 0.0) break;
    theta -= h.value / slope * from.across_theta;
    z -= h.value / slope * from.across_z;
    h = HeightAt(*surface_, plane_, theta, z);
  }
  // g = 0 along the piece: the way across follows from ∇g · (step + s' across) = 0.
  const double slope = h.by_theta * from.across_theta + h.by_z * from.across_z;
  const double sideways = slope == 0.0 ? 0.0 : -(h.by_theta * step_theta + h.by_z * step_z) / slope;
  CutSample sample;
  sample.theta = theta;
  sample.z = z;
  sample.theta_by_t = step_theta + sideways * from.across_theta;
  sample.z_by_t = step_z + sideways * from.across_z;
  sample.height_by_theta = h.by_theta;
  sample.height_by_z = h.by_z;
  const Metric metric(h);
  sample.sine_squared =
      Eigen::Vector2d(h.by_theta, h.by_z).dot(metric.Steepest(h)) / std::max(metric.Determinant(), 1e-300);
  sample.position = h.p;
  sample.by_t = sample.theta_by_t * h.p_theta + sample.z_by_t * h.p_z;
  return sample;
}

void CutCurve::Append(std::vector<CutNode>& nodes, const CutNode& to, double sign) const {
  const CutNode from = nodes.back();
  std::vector<std::pair<double, SurfacePlace>> crossings;
  for (const double theta : LinesBetween(from.theta, to.theta, surface_->theta_basis().spacing())) {
    const double t = FindAlong(from.theta, to.theta, theta, [&](double at) {
      const CutSample s = Between(from, to, at);
      return Along{s.theta, s.theta_by_t};
    });
    crossings.push_back({t, {theta, Between(from, to, t).z}});
  }
  for (const double z : LinesBetween(from.z, to.z, surface_->z_basis().breakpoints())) {
    const double t = FindAlong(from.z, to.z, z, [&](double at) {
      const CutSample s = Between(from, to, at);
      return Along{s.z, s.z_by_t};
    });
    crossings.push_back({t, {Between(from, to, t).theta, z}});
  }
  std::sort(crossings.begin(), crossings.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  for (const auto& [t, place] : crossings) {
    const auto node = NodeAt(place.theta, place.z, sign);
    if (node) nodes.push_back(*node);
  }
  nodes.push_back(to);
}

CutWalk CutCurve::Walk(const SurfacePlace& start, CutDirection direction, std::span<const SurfacePlace> targets) const {
  const double sign = direction == CutDirection::kPlusLeft ? 1.0 : -1.0;
  CutWalk walk;
  const auto first = NodeAt(start.theta, start.z, sign);
  if (!first) {
    walk.nodes.emplace_back();
    walk.nodes.back().theta = start.theta;
    walk.nodes.back().z = start.z;
    return walk;
  }
  std::vector<SurfacePlace> goals(targets.begin(), targets.end());
  goals.push_back(start);
  std::vector<Eigen::Vector3d> positions;
  positions.reserve(goals.size());
  for (const SurfacePlace& goal : goals) positions.push_back(surface_->Point(goal.theta, goal.z));
  walk.nodes.push_back(*first);
  double length = 0.5 * LongestStep(*first);
  for (std::size_t steps = 0; walk.nodes.size() < kMostNodes; ++steps) {
    const CutNode from = walk.nodes.back();
    auto to = Step(from, length, sign);
    while (!to && length > kShortestStep) to = Step(from, length *= 0.5, sign);
    if (!to) return walk;
    // The nearest goal on the piece; the start only once it has been left.
    std::optional<double> nearest;
    for (std::size_t k = 0; k < goals.size(); ++k) {
      if (k == targets.size() && steps < 4) continue;
      const auto u = Meets(from, *to, goals[k], positions[k]);
      if (u && (!nearest || *u < *nearest)) {
        nearest = u;
        walk.target = k;
      }
    }
    if (nearest) {
      const SurfacePlace& goal = goals[walk.target];
      const auto last = NodeAt(from.theta + AngleDifference(goal.theta, from.theta), goal.z, sign);
      if (!last) return walk;
      Append(walk.nodes, *last, sign);
      walk.nodes = Thinned(walk.nodes);
      walk.end = walk.target < targets.size() ? CutEnd::kTarget : CutEnd::kBackAtStart;
      return walk;
    }
    if (to->z < surface_->z_min() || to->z > surface_->z_max()) {
      walk.end = CutEnd::kLeftRange;
      return walk;
    }
    Append(walk.nodes, *to, sign);
    length = std::min(1.5 * length, LongestStep(*to));
  }
  return walk;
}

double CutCurve::Length(std::span<const CutNode> nodes) const {
  double length = 0.0;
  for (std::size_t k = 0; k + 1 < nodes.size(); ++k) {
    for (const QuadratureNode& node : UnitGauss()) {
      length += node.weight * Between(nodes[k], nodes[k + 1], node.x).by_t.norm();
    }
  }
  return length;
}

PathPoint CutCurve::InPlane(const SurfacePlace& place) const {
  const PathPoint radial = RadialPoint(*surface_, place);
  const Eigen::Vector3d skin = surface_->Normal(place.theta, place.z);
  const double cosine = plane_.normal.dot(skin);
  const double sine_squared = std::max(1.0 - cosine * cosine, kLimitedSine * kLimitedSine);
  const double factor = radial.by_radius.dot(skin) / sine_squared;
  return {place, radial.position, factor * (skin - cosine * plane_.normal)};
}

Eigen::Vector3d CutCurve::ByPlane(const SurfacePlace& place) const {
  const Eigen::Vector3d skin = surface_->Normal(place.theta, place.z);
  const double cosine = plane_.normal.dot(skin);
  return (plane_.normal - cosine * skin) / std::max(1.0 - cosine * cosine, kLimitedSine * kLimitedSine);
}

}  // namespace annulus
