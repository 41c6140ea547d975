#include "modeling/measure/taut_string.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
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
constexpr int kMostHalvings = 3;
constexpr double kFailed = -1.0;  ///< No gain could be had.
constexpr double kUnbounded = std::numeric_limits<double>::infinity();

Eigen::Vector3d Outward(double theta) { return {std::cos(theta), std::sin(theta), 0.0}; }
Eigen::Vector3d Sideways(double theta) { return {-std::sin(theta), std::cos(theta), 0.0}; }

double AngleOf(const Eigen::Vector3d& position) { return WrapAngle(std::atan2(position.y(), position.x())); }

/// Which points are moved to the surface.
enum class Approach {
  kFromInside,  ///< Those inside the body.
  kAlways,
};
/// Moves a point to the surface a step at a time along the gradient of rho - r(theta, z), so that a point beside a
/// steep wall goes to the wall and not up to its rim.
Eigen::Vector3d Approached(const SplineSurface& surface, const StringRules& rules, Approach approach,
                           Eigen::Vector3d position) {
  constexpr int kSteps = 3;
  for (int step = 0; step < kSteps; ++step) {
    const double theta = AngleOf(position);
    const double rho = position.head<2>().norm();
    const RadiusJet jet = surface.Jet(theta, position.z());
    const double outside = rho - jet.r;
    if ((outside >= 0.0 && approach == Approach::kFromInside) || rho <= 0.0) break;
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

/// The vertex on the surface under it, towards the axis.
StringVertex Landed(const SplineSurface& surface, const StringVertex& from) {
  StringVertex vertex = from;
  vertex.touches = true;
  vertex.position = surface.Point(from.place.theta, from.place.z);
  return vertex;
}

}  // namespace

/// What one vertex brings to System.
struct TautString::VertexModel {
  Eigen::Matrix3d move = Eigen::Matrix3d::Zero();
  Eigen::Matrix3d bend = Eigen::Matrix3d::Zero();
  Eigen::Matrix3d diagonal = Eigen::Matrix3d::Identity();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  Eigen::Vector3d low = Eigen::Vector3d::Zero();
  Eigen::Vector3d high = Eigen::Vector3d::Zero();
};

/// The energy to second order in three numbers per vertex: those of (theta, z, rho - r) for a vertex on the surface,
/// those of the same in the plane that touches the level of rho - r for one off it.
struct TautString::System {
  ChainSystem chain;
  std::vector<Eigen::Matrix3d> moves;  ///< Columns: d(position)/d(number).
  std::vector<Eigen::Matrix3d> bends;  ///< What the surface's curvature adds to the diagonal of H.
};

StringVertex VertexAt(const SplineSurface& surface, const SurfacePlace& place) {
  return {place, surface.Point(place.theta, place.z)};
}

StringVertex VertexNear(const SplineSurface& surface, const StringRules& rules, const Eigen::Vector3d& position) {
  Eigen::Vector3d inside = position;
  inside.z() = std::clamp(inside.z(), rules.z_min, rules.z_max);
  return Lifted(surface, {}, Approached(surface, rules, Approach::kFromInside, inside));
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

TautString::VertexModel TautString::LineariseVertex(std::size_t k) const {
  VertexModel model;
  const StringVertex& vertex = vertices_[k];
  const Eigen::Vector3d pull = Pull(k);
  const RadiusJet jet = surface_->Jet(vertex.place.theta, vertex.place.z);
  const Eigen::Vector3d e_r = Outward(vertex.place.theta);
  const Eigen::Vector3d e_t = Sideways(vertex.place.theta);
  const double rho = vertex.touches ? jet.r : vertex.position.dot(e_r);
  Eigen::Matrix3d& move = model.move;
  move.col(0) = jet.r_theta * e_r + rho * e_t;
  move.col(1) = jet.r_z * e_r + Eigen::Vector3d::UnitZ();
  move.col(2) = e_r;
  const std::size_t before = k > 0 ? k - 1 : vertices_.size() - 1;
  const double stiffness = 1.0 / vertices_[before].share + 1.0 / vertex.share;
  model.diagonal = stiffness * (move.transpose() * move);
  if (vertex.touches) {  // the pull times the second derivatives of r(theta, z)·e_r + z·e_z + number·e_r
    const double around = pull.dot((jet.r_theta_theta - jet.r) * e_r + 2.0 * jet.r_theta * e_t);
    const double mixed = pull.dot(jet.r_theta_z * e_r + jet.r_z * e_t);
    const double sideways = pull.dot(e_t);
    model.bend << around, mixed, sideways, mixed, pull.dot(jet.r_z_z * e_r), 0.0, sideways, 0.0, 0.0;
  }
  model.right = -(move.transpose() * pull);
  const bool held = vertex.hold == VertexHold::kHeld;
  const double outside = vertex.touches ? 0.0 : std::max(0.0, rho - jet.r);
  model.low = {held ? 0.0 : -kUnbounded, held ? 0.0 : rules_.z_min - vertex.place.z, -outside};
  model.high = {held ? 0.0 : kUnbounded, held ? 0.0 : rules_.z_max - vertex.place.z,
                rules_.side == StringSide::kOnSurface ? 0.0 : kUnbounded};
  return model;
}

TautString::System TautString::Linearise() const {
  const std::size_t count = vertices_.size();
  System system;
  system.moves.assign(count, Eigen::Matrix3d::Zero());
  system.bends = system.moves;
  system.chain.diagonal.assign(count, Eigen::Matrix3d::Identity());
  system.chain.right.assign(count, Eigen::Vector3d::Zero());
  system.chain.low = system.chain.right;
  system.chain.high = system.chain.right;
  for (std::size_t k = 0; k < count; ++k) {
    if (vertices_[k].hold == VertexHold::kFixed) continue;
    const VertexModel model = LineariseVertex(k);
    system.moves[k] = model.move;
    system.bends[k] = model.bend;
    system.chain.diagonal[k] = model.diagonal;
    system.chain.right[k] = model.right;
    system.chain.low[k] = model.low;
    system.chain.high[k] = model.high;
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
    const StringVertex& from = vertices_[k];
    if (from.hold == VertexHold::kFixed) continue;
    const Eigen::Vector3d by = factor * step[k];
    if (from.touches) {
      SurfacePlace place = from.place;
      if (from.hold == VertexHold::kSliding) {
        place = {WrapAngle(place.theta + by.x()), std::clamp(place.z + by.y(), rules_.z_min, rules_.z_max)};
      }
      moved[k].place = place;
      moved[k].touches = !(by.z() > 0.0);
      moved[k].position =
          PointFromCylindrical(place.theta, surface_->Radius(place.theta, place.z) + std::max(0.0, by.z()), place.z);
      continue;
    }
    Eigen::Vector3d position = from.position + system.moves[k] * by;
    if (from.hold == VertexHold::kSliding) {
      position.z() = std::clamp(position.z(), rules_.z_min, rules_.z_max);
      const bool lands = by.z() <= system.chain.low[k].z();
      position = Approached(*surface_, rules_, lands ? Approach::kAlways : Approach::kFromInside, position);
      moved[k] = Lifted(*surface_, from, position);
      if (lands) moved[k] = Landed(*surface_, moved[k]);
    } else {
      moved[k] = Lifted(*surface_, from, position);
    }
  }
  return moved;
}

double TautString::Step(const System& system, const ChainSystem& model, double energy) {
  const std::optional<std::vector<Eigen::Vector3d>> step = MinimiseChain(model);
  if (!step) return kFailed;
  double gain = 0.0;
  const std::vector<Eigen::Vector3d> product = Apply(model, *step);
  for (std::size_t k = 0; k < product.size(); ++k) gain += (*step)[k].dot(model.right[k] - 0.5 * product[k]);
  if (gain < 0.0) return kFailed;
  if (gain <= kConverged * energy) return 0.0;
  for (int halvings = 0; halvings <= kMostHalvings; ++halvings) {
    const double factor = std::ldexp(1.0, -halvings);
    std::vector<StringVertex> moved = Moved(system, *step, factor);
    const double moved_energy = Energy(moved);
    if (!(moved_energy < energy - 0.01 * factor * gain)) continue;
    vertices_ = std::move(moved);
    return energy - moved_energy;
  }
  return kFailed;
}

void TautString::Tighten(const TightenEffort& effort) {
  double damping = 0.0;
  for (int steps = 0; steps < effort.most_steps; ++steps) {
    const double energy = Energy(vertices_);
    const System system = Linearise();
    // Newton's model; where it is not convex or leads astray, that of Gauss and Newton, damped if need be.
    ChainSystem model = system.chain;
    for (std::size_t k = 0; k < vertices_.size(); ++k) model.diagonal[k] += system.bends[k];
    double gained = damping > 0.0 ? kFailed : Step(system, model, energy);
    while (gained == kFailed) {
      for (std::size_t k = 0; k < vertices_.size(); ++k) {
        model.diagonal[k] = (1.0 + damping) * system.chain.diagonal[k];
      }
      gained = Step(system, model, energy);
      if (gained != kFailed) break;
      if (damping >= kLastDamping) return;
      damping = std::max(kFirstDamping, 10.0 * damping);
    }
    if (gained <= effort.least_gain * energy) return;
    damping = damping > kFirstDamping ? 0.1 * damping : 0.0;
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
