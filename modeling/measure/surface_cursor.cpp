#include "modeling/measure/surface_cursor.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>

#include "base/frames.h"
#include "modeling/measure/number_text.h"
#include "modeling/measure/place_check.h"
#include "modeling/measure/surface_derivatives.h"

namespace annulus {
namespace {

constexpr double kStep = 0.5;    // mm of arc
constexpr int kBisections = 30;  // of a step, to the edge: below a nanometre

/// A moving point: (theta, z) and their change per mm of arc, or (theta, z) alone and 0.
using State = Eigen::Vector4d;
using Motion = std::function<State(const State&)>;

SurfacePlace PlaceOf(const State& state) { return {state[0], state[1]}; }

/// (theta', z') of a unit tangent at `heading`.
Eigen::Vector2d ParametersOf(const SurfaceDerivatives& p, double heading) {
  const Eigen::Vector3d across = p.by_theta.normalized();
  const Eigen::Vector3d up = p.by_theta.cross(p.by_z).cross(across).normalized();
  const double z = std::sin(heading) / p.by_z.dot(up);
  return {(std::cos(heading) - z * p.by_z.dot(across)) / p.by_theta.norm(), z};
}

double HeadingOf(const SurfaceDerivatives& p, const Eigen::Vector2d& parameters) {
  const Eigen::Vector3d tangent = parameters[0] * p.by_theta + parameters[1] * p.by_z;
  const Eigen::Vector3d across = p.by_theta.normalized();
  const Eigen::Vector3d up = p.by_theta.cross(p.by_z).cross(across).normalized();
  return WrapAngle(std::atan2(tangent.dot(up), tangent.dot(across)));
}

/// The geodesic equation: acceleration has no part in the tangent plane. With Q the acceleration at constant (theta',
/// z'), (theta'', z'') solves [E F; F G]·(theta'', z'') = -(P_theta·Q, P_z·Q).
State GeodesicMotion(const SplineSurface& surface, const State& state) {
  const SurfaceDerivatives p = DerivativesAt(surface, PlaceOf(state));
  const double u = state[2];
  const double v = state[3];
  const Eigen::Vector3d q = u * u * p.by_theta_theta + 2.0 * u * v * p.by_theta_z + v * v * p.by_z_z;
  const double e = p.by_theta.squaredNorm();
  const double f = p.by_theta.dot(p.by_z);
  const double g = p.by_z.squaredNorm();
  const double a = -p.by_theta.dot(q);
  const double b = -p.by_z.dot(q);
  const double determinant = e * g - f * f;
  return {u, v, (g * a - f * b) / determinant, (e * b - f * a) / determinant};
}

/// One step of the classical fourth-order rule.
State Advanced(const Motion& motion, const State& state, double step) {
  const State k1 = motion(state);
  const State k2 = motion(state + 0.5 * step * k1);
  const State k3 = motion(state + 0.5 * step * k2);
  const State k4 = motion(state + step * k3);
  return state + step / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
}

/// What a cursor may not enter; nothing where it may.
std::optional<CursorStop> Barrier(const MeasuredSurface& body, const SurfacePlace& place) {
  if (!std::isfinite(place.theta) || !std::isfinite(place.z)) return CursorStop::kAxis;  // ran into the singular point
  if (!(place.z <= body.surface().z_max())) return CursorStop::kTop;
  if (!(place.z >= body.surface().z_min())) return CursorStop::kBottom;
  if (body.KnowledgeAt(place.theta, place.z) == Knowledge::kUnknown) return CursorStop::kUnseen;
  if (!(body.surface().Radius(place.theta, place.z) >= kAxisRadius)) return CursorStop::kAxis;
  return std::nullopt;
}

/// The way so far.
struct Walk {
  const MeasuredSurface& body;
  State state;
  CursorMove move{};

  void Enter(const State& next, double length) {
    state = next;
    move.travelled += length;
    move.path.push_back(RadialPoint(body.surface(), PlaceOf(next)));
  }
};

/// Goes to `at(whole)` in one stride if it may; else to the last allowed point before, which it seeks by halving, and
/// says why. `length(part)` is the arc up to there.
bool Stride(Walk& walk, double whole, const std::function<State(double)>& at,
            const std::function<double(double)>& length) {
  const State end = at(whole);
  std::optional<CursorStop> barrier = Barrier(walk.body, PlaceOf(end));
  if (!barrier) {
    walk.Enter(end, length(whole));
    return true;
  }
  double inside = 0.0;
  double outside = whole;
  for (int k = 0; k < kBisections; ++k) {
    const double middle = 0.5 * (inside + outside);
    const auto stop = Barrier(walk.body, PlaceOf(at(middle)));
    if (stop) barrier = stop;
    (stop ? outside : inside) = middle;
  }
  if (inside > 0.0) walk.Enter(at(inside), length(inside));
  walk.move.stop = *barrier;
  return false;
}

/// Follows a motion of unit speed.
Walk Follow(const MeasuredSurface& body, const State& start, const Motion& motion, double distance) {
  Walk walk{body, start};
  walk.Enter(start, 0.0);
  const double steps = std::max(1.0, std::ceil(distance / kStep));
  const double step = distance / steps;
  for (double k = 0.0; k < steps && step > 0.0; k += 1.0) {
    const State from = walk.state;
    const auto at = [&](double part) { return Advanced(motion, from, part); };
    if (!Stride(walk, step, at, [](double part) { return part; })) break;
  }
  return walk;
}

CursorMove Finished(Walk walk, const Eigen::Vector2d& parameters) {
  const SurfacePlace end = PlaceOf(walk.state);
  walk.move.heading = HeadingOf(DerivativesAt(walk.body.surface(), end), parameters);
  for (PathPoint& point : walk.move.path) point.place.theta = WrapAngle(point.place.theta);
  walk.move.place = walk.move.path.back().place;
  return std::move(walk.move);
}

Status CheckMove(const MeasuredSurface& body, const SurfacePlace& from, double distance) {
  const std::string attempted = "move the cursor from " + PlaceText(from);
  RETURN_IF_ERROR(CheckPlace(body, from, attempted));
  if (std::abs(distance) <= kLongestMove) return {};
  return Fail(attempted, "the way of " + NumberText(distance) + " mm is too long",
              "give at most " + NumberText(kLongestMove) + " mm");
}

}  // namespace

std::string_view CursorStopText(CursorStop stop) {
  switch (stop) {
    case CursorStop::kArrived:
      return "arrived";
    case CursorStop::kTop:
      return "stopped at the upper end of the scan";
    case CursorStop::kBottom:
      return "stopped at the lower end of the scan";
    case CursorStop::kUnseen:
      return "stopped where the surface was not seen";
    case CursorStop::kAxis:
      return "stopped where the surface meets the ring's axis";
  }
  return "arrived";
}

Result<CursorMove> StepCursor(const MeasuredSurface& body, const SurfacePlace& from, double d_theta, double d_z) {
  RETURN_IF_ERROR(CheckMove(body, from, 0.0));
  if (!(std::abs(d_theta) <= kTwoPi) || !(std::abs(d_z) <= kLongestMove)) {
    return Fail("move the cursor from " + PlaceText(from), "a step is not a number, or too long",
                "give at most a turn, and at most " + NumberText(kLongestMove) + " mm up or down");
  }
  const SplineSurface& surface = body.surface();
  Walk walk{body, State(from.theta, from.z, d_theta, d_z)};
  walk.Enter(walk.state, 0.0);
  double done = 0.0;  // share of the way
  while (done < 1.0) {
    const SurfaceDerivatives p = DerivativesAt(surface, PlaceOf(walk.state));
    const double speed = (d_theta * p.by_theta + d_z * p.by_z).norm();
    // Half a millimetre and a degree at most, but no more parts than the longest way has on a smooth skin.
    const double parts = std::max({1.0, speed / kStep, std::abs(d_z) / kStep, DegreesFromRadians(std::abs(d_theta))});
    const double part = std::min(1.0 - done, 1.0 / std::min(parts, kLongestMove / kStep));
    const double start = done;
    const auto at = [&](double t) {
      return State(from.theta + (start + t) * d_theta, from.z + (start + t) * d_z, d_theta, d_z);
    };
    const auto speed_at = [&](double t) {
      const SurfaceDerivatives q = DerivativesAt(surface, PlaceOf(at(t)));
      return (d_theta * q.by_theta + d_z * q.by_z).norm();
    };
    const auto length = [&](double t) { return t / 6.0 * (speed + 4.0 * speed_at(0.5 * t) + speed_at(t)); };  // Simpson
    if (!Stride(walk, part, at, length)) break;
    done = part < 1.0 - start ? start + part : 1.0;
  }
  return Finished(std::move(walk), Eigen::Vector2d(d_theta, d_z));
}

Result<CursorMove> MoveCursorAlong(const MeasuredSurface& body, const SurfacePlace& from, ParameterLine line,
                                   double distance) {
  RETURN_IF_ERROR(CheckMove(body, from, distance));
  const double sense = distance < 0.0 ? -1.0 : 1.0;
  const bool around = line == ParameterLine::kAroundTheBody;
  const Motion motion = [&](const State& state) -> State {
    const SurfaceDerivatives p = DerivativesAt(body.surface(), PlaceOf(state));
    if (around) return {sense / p.by_theta.norm(), 0.0, 0.0, 0.0};
    return {0.0, sense / p.by_z.norm(), 0.0, 0.0};
  };
  Walk walk = Follow(body, State(from.theta, from.z, 0.0, 0.0), motion, std::abs(distance));
  return Finished(std::move(walk), around ? Eigen::Vector2d(sense, 0.0) : Eigen::Vector2d(0.0, sense));
}

Result<CursorMove> MoveCursorStraight(const MeasuredSurface& body, const SurfacePlace& from, double heading,
                                      double distance) {
  RETURN_IF_ERROR(CheckMove(body, from, distance));
  if (!std::isfinite(heading)) {
    return Fail("move the cursor from " + PlaceText(from), "the heading is not a finite number", "give it in degrees");
  }
  const double sense = distance < 0.0 ? -1.0 : 1.0;
  const Eigen::Vector2d start = sense * ParametersOf(DerivativesAt(body.surface(), from), heading);
  const Motion motion = [&](const State& state) { return GeodesicMotion(body.surface(), state); };
  Walk walk = Follow(body, State(from.theta, from.z, start[0], start[1]), motion, std::abs(distance));
  const Eigen::Vector2d end = walk.state.tail<2>();
  return Finished(std::move(walk), end);
}

}  // namespace annulus
