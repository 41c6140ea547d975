#include "modeling/flatten/geodesic_side.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace annulus {
namespace {

using Eigen::Vector2d;

/// Gauss's rule of five nodes on [0, 1].
constexpr std::array<double, 5> kNode{0.04691007703066802, 0.23076534494715845, 0.5, 0.7692346550528415,
                                      0.953089922969332};
constexpr std::array<double, 5> kWeight{0.11846344252809454, 0.23931433524968324, 0.28444444444444444,
                                        0.23931433524968324, 0.11846344252809454};
/// Steps of the difference quotients, as parts of the side: the first finds the bend, the second polishes it.
constexpr std::array<double, 2> kProbe{0.05, 0.01};
constexpr double kMostBend = 0.5;

/// Speed of a point that moves with `velocity` (rad, mm per unit) at a place.
double SpeedAt(const SurfaceSegment& segment, const Vector2d& place, const Vector2d& velocity) {
  const RadiusJet jet = segment.surface.Jet(place.x(), place.y());
  const double outwards = jet.r_theta * velocity.x() + jet.r_z * velocity.y();
  const double around = jet.r * velocity.x();
  if (segment.axis.IsRingAxis()) return std::sqrt(outwards * outwards + around * around + velocity.y() * velocity.y());
  const double c = std::cos(place.x());
  const double s = std::sin(place.x());
  const double d = place.y() - segment.axis.z_middle;
  const Vector2d sideways = velocity.y() * (segment.axis.slope + 2.0 * d * segment.axis.bend);
  return Eigen::Vector3d(outwards * c - around * s + sideways.x(), outwards * s + around * c + sideways.y(),
                         velocity.y())
      .norm();
}

/// A side as a curve of two unknowns: from + t·along + across·(b0·t(1−t) + b1·t(1−t)(1−2t)).
struct Side {
  const SurfaceSegment& segment;
  Vector2d from;
  Vector2d along;
  Vector2d across;

  [[nodiscard]] double Length(const Vector2d& bend) const {
    double length = 0.0;
    for (std::size_t k = 0; k < kNode.size(); ++k) {
      const double t = kNode[k];
      const double hump = t * (1.0 - t);
      const double off = hump * (bend[0] + bend[1] * (1.0 - 2.0 * t));
      const double off_rate = (1.0 - 2.0 * t) * (bend[0] + bend[1] * (1.0 - 2.0 * t)) - 2.0 * hump * bend[1];
      length += kWeight[k] * SpeedAt(segment, from + t * along + off * across, along + off_rate * across);
    }
    return length;
  }
};

/// One Newton step by central differences; the bend as it was if the length has no minimum there.
Vector2d Straightened(const Side& side, const Vector2d& bend, double probe, double length) {
  const Vector2d u(probe, 0.0);
  const Vector2d v(0.0, probe);
  const double up = side.Length(bend + u);
  const double down = side.Length(bend - u);
  const double right = side.Length(bend + v);
  const double left = side.Length(bend - v);
  const double corner = side.Length(bend + u + v);
  const double h00 = up - 2.0 * length + down;
  const double h11 = right - 2.0 * length + left;
  const double h01 = corner - up - right + length;
  const double determinant = h00 * h11 - h01 * h01;
  if (!(h00 > 0.0 && determinant > 0.0)) return bend;
  const Vector2d slope(0.5 * (up - down), 0.5 * (right - left));
  const Vector2d step(h11 * slope[0] - h01 * slope[1], h00 * slope[1] - h01 * slope[0]);
  return bend - probe / determinant * step;
}

}  // namespace

double GeodesicSide(const SurfaceSegment& segment, const Vector2d& from, const Vector2d& to) {
  const double chord = (segment.Point(to.x(), to.y()) - segment.Point(from.x(), from.y())).norm();
  const Vector2d along = to - from;
  const Vector2d middle = from + 0.5 * along;
  const double r = segment.surface.Radius(middle.x(), middle.y());
  // A quarter turn in the plane of (r·theta, z), as long as the side.
  const Side side{segment, from, along, Vector2d(-along.y() / std::max(r, 1e-3), along.x() * r)};
  Vector2d bend = Vector2d::Zero();
  double length = side.Length(bend);
  for (const double probe : kProbe) {
    const Vector2d next = Straightened(side, bend, probe, length);
    if (!(next.cwiseAbs().maxCoeff() <= kMostBend)) break;
    const double shorter = side.Length(next);
    if (!(shorter < length)) break;
    bend = next;
    length = shorter;
  }
  return std::max(length, chord);
}

double StraightLength(const SurfaceSegment& segment, const Vector2d& from, const Vector2d& to) {
  return Side{segment, from, to - from, Vector2d::Zero()}.Length(Vector2d::Zero());
}

}  // namespace annulus
