#include "modeling/measure/taut_string.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>

#include "base/ensure.h"
#include "base/frames.h"
#include "modeling/measure/string_system.h"

namespace annulus {
namespace {

/// Steps whose promised gain is smaller than this share of the energy are not worth taking.
constexpr double kConverged = 1e-14;
constexpr double kFirstDamping = 1e-3;
constexpr double kLastDamping = 1e8;
constexpr double kShortestFactor = 1.0 / 64.0;
/// A vertex leaves the surface when it is pulled off it by more than this share of the tension.
constexpr double kReleasePull = 1e-12;

Eigen::Vector3d Outward(double theta) { return {std::cos(theta), std::sin(theta), 0.0}; }
Eigen::Vector3d Sideways(double theta) { return {-std::sin(theta), std::cos(theta), 0.0}; }

/// Position and derivatives of the surface P(theta, z) = r·e_r + z·e_z.
struct SurfaceFrame {
  Eigen::Vector3d by_theta, by_z;
  Eigen::Vector3d by_theta_theta, by_theta_z, by_z_z;
  Eigen::Vector3d normal;  ///< Outward, not of unit length.
};

SurfaceFrame FrameAt(const SplineSurface& surface, const SurfacePlace& place) {
  const RadiusJet jet = surface.Jet(place.theta, place.z);
  const Eigen::Vector3d e_r = Outward(place.theta);
  const Eigen::Vector3d e_t = Sideways(place.theta);
  SurfaceFrame frame;
  frame.by_theta = jet.r_theta * e_r + jet.r * e_t;
  frame.by_z = jet.r_z * e_r + Eigen::Vector3d::UnitZ();
  frame.by_theta_theta = (jet.r_theta_theta - jet.r) * e_r + 2.0 * jet.r_theta * e_t;
  frame.by_theta_z = jet.r_theta_z * e_r + jet.r_z * e_t;
  frame.by_z_z = jet.r_z_z * e_r;
  frame.normal = frame.by_theta.cross(frame.by_z);
  return frame;
}

double AngleOf(const Eigen::Vector3d& position) { return WrapAngle(std::atan2(position.y(), position.x())); }

/// A step at a time along the gradient of rho - r(theta, z), so that a point beside a steep wall goes to the wall and
/// not up to its rim.
Eigen::Vector3d PushedOut(const SplineSurface& surface, const StringRules& rules, Eigen::Vector3d position) {
  constexpr int kSteps = 3;
  for (int step = 0; step < kSteps; ++step) {
    const double theta = AngleOf(position);
    const double rho = position.head<2>().norm();
    const RadiusJet jet = surface.Jet(theta, position.z());
    const double outside = rho - jet.r;
    if (outside >= 0.0 || rho <= 0.0) break;
    const Eigen::Vector3d gradient =
        Outward(theta) - jet.r_theta / rho * Sideways(theta) - jet.r_z * Eigen::Vector3d::UnitZ();
    position -= outside / gradient.squaredNorm() * gradient;
    position.z() = std::clamp(position.z(), rules.z_min, rules.z_max);
  }
  return position;
}

/// The vertex `from` moved to `position`, or to the surface above it along the ray from the axis.
StringVertex Lifted(const SplineSurface& surface, const StringVertex& from, const Eigen::Vector3d& position) {
  StringVertex vertex = from;
  if (from.hold == VertexHold::kSliding) vertex.place = {AngleOf(position), position.z()};
  const double radius = surface.Radius(vertex.place.theta, vertex.place.z);
  const double rho = position.head<2>().dot(Outward(vertex.place.theta).head<2>());
  vertex.touches = rho <= radius;
  vertex.position = vertex.touches ? PointFromCylindrical(vertex.place.theta, radius, vertex.place.z) : position;
  return vertex;
}

}  // namespace

/// The energy to second order in the steps of every vertex: three numbers each, of which those without a column in
/// `moves` are 0.
struct TautString::System {
  ChainSystem chain;
  std::vector<Eigen::Matrix3d> moves;  ///< Columns: d(position)/d(step).
  std::vector<Eigen::Matrix3d> scale;  ///< Of the damping.
  std::vector<char> on_surface;        ///< The steps are those of (theta, z).
};

StringVertex VertexAt(const SplineSurface& surface, const SurfacePlace& place) {
  return {place, surface.Point(place.theta, place.z)};
}

StringVertex VertexNear(const SplineSurface& surface, const StringRules& rules, const Eigen::Vector3d& position) {
  Eigen::Vector3d inside = position;
  inside.z() = std::clamp(inside.z(), rules.z_min, rules.z_max);
  return Lifted(surface, {}, PushedOut(surface, rules, inside));
}

TautString::TautString(const SplineSurface& surface, const StringRules& rules, std::vector<StringVertex> vertices)
    : surface_(&surface), rules_(rules), vertices_(std::move(vertices)) {
  ENSURE(vertices_.size() >= 3, "a string has three vertices or more");
  ENSURE(rules.ends == PathEnds::kClosed ||
             (vertices_.front().hold == VertexHold::kFixed && vertices_.back().hold == VertexHold::kFixed),
         "the ends of an open string are fixed");
  double sum = 0.0;
  for (std::size_t k = 0; k < edge_count(); ++k) sum += vertices_[k].share;
  for (StringVertex& vertex : vertices_) vertex.share /= sum;
}

std::size_t TautString::edge_count() const {
  return rules_.ends == PathEnds::kClosed ? vertices_.size() : vertices_.size() - 1;
}

double TautString::Length() const {
  double length = 0.0;
  for (std::size_t k = 0; k < edge_count(); ++k) length += (vertices_[Next(k)].position - vertices_[k].position).norm();
  return length;
}

double TautString::Energy(const std::vector<StringVertex>& vertices) const {
  double energy = 0.0;
  for (std::size_t k = 0; k < edge_count(); ++k) {
    energy += 0.5 * (vertices[Next(k)].position - vertices[k].position).squaredNorm() / vertices[k].share;
  }
  return energy;
}

Eigen::Vector3d TautString::Pull(std::size_t k) const {
  const std::size_t before = k > 0 ? k - 1 : vertices_.size() - 1;
  return (vertices_[k].position - vertices_[before].position) / vertices_[before].share -
         (vertices_[Next(k)].position - vertices_[k].position) / vertices_[k].share;
}

TautString::System TautString::Linearise() const {
  const std::size_t count = vertices_.size();
  System system;
  system.moves.assign(count, Eigen::Matrix3d::Zero());
  system.scale.assign(count, Eigen::Matrix3d::Identity());
  system.on_surface.assign(count, 0);
  system.chain.diagonal.assign(count, Eigen::Matrix3d::Identity());
  system.chain.right.assign(count, Eigen::Vector3d::Zero());
  const double tension = Length();
  for (std::size_t k = 0; k < count; ++k) {
    const StringVertex& vertex = vertices_[k];
    if (vertex.hold == VertexHold::kFixed) continue;
    const Eigen::Vector3d pull = Pull(k);  // the vertex is drawn along -pull
    const double limit = -kReleasePull * tension;
    const bool may_leave = rules_.side == StringSide::kOutside;
    const bool at_low = vertex.place.z <= rules_.z_min;
    const bool at_high = vertex.place.z >= rules_.z_max;
    Eigen::Matrix3d& move = system.moves[k];
    Eigen::Matrix3d bend = Eigen::Matrix3d::Zero();
    if (vertex.hold == VertexHold::kHeld) {
      const Eigen::Vector3d outward = Outward(vertex.place.theta);
      if (!vertex.touches || (may_leave && pull.dot(outward) < limit)) move.col(0) = outward;
    } else {
      bool stays = vertex.touches;
      SurfaceFrame frame;
      if (vertex.touches) {
        frame = FrameAt(*surface_, vertex.place);
        Eigen::Vector3d normal = frame.normal;
        if (at_low || at_high) normal.z() = 0.0;  // the rim takes up what pulls along z
        stays = !may_leave || pull.dot(normal) >= limit * normal.norm();
      }
      const double along_z = stays ? pull.dot(frame.by_z) : pull.z();
      const bool rim = (at_low && along_z > 0.0) || (at_high && along_z < 0.0);
      if (stays) {
        system.on_surface[k] = 1;
        move.col(0) = frame.by_theta;
        bend(0, 0) = pull.dot(frame.by_theta_theta);
        if (!rim) {
          move.col(1) = frame.by_z;
          bend(0, 1) = bend(1, 0) = pull.dot(frame.by_theta_z);
          bend(1, 1) = pull.dot(frame.by_z_z);
        }
      } else {
        move.setIdentity();
        if (rim) move.col(2).setZero();
      }
    }
    const std::size_t before = k > 0 ? k - 1 : count - 1;
    const double stiffness = 1.0 / vertices_[before].share + 1.0 / vertex.share;
    system.scale[k] = stiffness * (move.transpose() * move);
    system.chain.right[k] = -(move.transpose() * pull);
    for (int column = 0; column < 3; ++column) {
      if (move.col(column).isZero(0.0)) system.scale[k](column, column) = stiffness;
    }
    system.chain.diagonal[k] = system.scale[k] + bend;
  }
  for (std::size_t k = 0; k + 1 < count; ++k) {
    system.chain.next.emplace_back(-(system.moves[k].transpose() * system.moves[k + 1]) / vertices_[k].share);
  }
  if (rules_.ends == PathEnds::kClosed) {
    system.chain.around = -(system.moves.front().transpose() * system.moves.back()) / vertices_.back().share;
  }
  return system;
}

std::vector<StringVertex> TautString::Moved(const System& system, const std::vector<Eigen::Vector3d>& step,
                                            double factor) const {
  std::vector<StringVertex> moved = vertices_;
  for (std::size_t k = 0; k < moved.size(); ++k) {
    if (system.moves[k].isZero(0.0)) continue;
    if (system.on_surface[k] != 0) {
      SurfacePlace place = vertices_[k].place;
      place.theta = WrapAngle(place.theta + factor * step[k].x());
      if (!system.moves[k].col(1).isZero(0.0)) {
        place.z = std::clamp(place.z + factor * step[k].y(), rules_.z_min, rules_.z_max);
      }
      moved[k].place = place;
      moved[k].position = surface_->Point(place.theta, place.z);
      moved[k].touches = true;
    } else if (vertices_[k].hold == VertexHold::kHeld) {
      moved[k] = Lifted(*surface_, vertices_[k], vertices_[k].position + factor * system.moves[k] * step[k]);
    } else {
      Eigen::Vector3d position = vertices_[k].position + factor * system.moves[k] * step[k];
      position.z() = std::clamp(position.z(), rules_.z_min, rules_.z_max);
      moved[k] = Lifted(*surface_, vertices_[k], PushedOut(*surface_, rules_, position));
    }
  }
  return moved;
}

void TautString::Tighten(int max_steps) {
  double damping = 0.0;
  double energy = Energy(vertices_);
  for (int steps = 0; steps < max_steps; ++steps) {
    const System system = Linearise();
    std::optional<std::vector<Eigen::Vector3d>> step = SolveChain(system.chain, system.scale, damping);
    while (!step && damping < kLastDamping) {
      damping = std::max(kFirstDamping, 10.0 * damping);
      step = SolveChain(system.chain, system.scale, damping);
    }
    if (!step) return;
    double gain = 0.0;
    for (std::size_t k = 0; k < vertices_.size(); ++k) gain += system.chain.right[k].dot((*step)[k]);
    if (!(gain > kConverged * energy)) return;
    double factor = 1.0;
    for (; factor >= kShortestFactor; factor *= 0.5) {
      std::vector<StringVertex> moved = Moved(system, *step, factor);
      const double moved_energy = Energy(moved);
      if (!(moved_energy < energy - 1e-4 * factor * gain)) continue;
      vertices_ = std::move(moved);
      energy = moved_energy;
      break;
    }
    if (factor == 1.0) {
      damping = damping > kFirstDamping ? 0.1 * damping : 0.0;
    } else if (factor < kShortestFactor) {
      if (damping >= kLastDamping) return;
      damping = std::max(kFirstDamping, 10.0 * damping);
    }
  }
}

void TautString::Split(const std::vector<std::size_t>& parts) {
  ENSURE(parts.size() == edge_count(), "one number of parts per edge");
  std::vector<StringVertex> refined;
  for (std::size_t k = 0; k < vertices_.size(); ++k) {
    const StringVertex& from = vertices_[k];
    const std::size_t count = k < parts.size() ? parts[k] : 1;
    refined.push_back(from);
    refined.back().share = from.share / static_cast<double>(count);
    const StringVertex& to = vertices_[Next(k)];
    for (std::size_t part = 1; part < count; ++part) {
      const double t = static_cast<double>(part) / static_cast<double>(count);
      const bool flat = rules_.side == StringSide::kOnSurface || (from.touches && to.touches);
      StringVertex vertex;
      if (flat) {
        const double turn = AngleDifference(to.place.theta, from.place.theta);
        vertex = VertexAt(*surface_,
                          {WrapAngle(from.place.theta + t * turn), from.place.z + t * (to.place.z - from.place.z)});
      } else {
        vertex = VertexNear(*surface_, rules_, from.position + t * (to.position - from.position));
      }
      vertex.share = refined.back().share;
      refined.push_back(vertex);
    }
  }
  vertices_ = std::move(refined);
}

void TautString::ShareByLength() {
  const double length = Length();
  const double least = 1e-6 / static_cast<double>(vertices_.size());
  for (std::size_t k = 0; k < edge_count(); ++k) {
    vertices_[k].share = std::max(least, (vertices_[Next(k)].position - vertices_[k].position).norm() / length);
  }
}

}  // namespace annulus
