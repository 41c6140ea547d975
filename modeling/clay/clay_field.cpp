#include "modeling/clay/clay_field.h"

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <numbers>
#include <random>
#include <unsupported/Eigen/AutoDiff>
#include <vector>

namespace annulus {
namespace {

using Eigen::Vector3d;
using Number = Eigen::AutoDiffScalar<Vector3d>;
using Point = Eigen::Matrix<Number, 3, 1>;

/// The dent gives way to the rim between these q²: within, it is the paper's parabola.
constexpr double kBlendFrom = 0.75;
constexpr double kBlendTo = 1.25;
/// The rim fades from this part of rho² on.
constexpr double kRimFades = 0.6;

/// A field written once, on numbers that carry their derivatives by x, y and z.
template <class Motion>
ClayField FieldOf(Motion motion) {
  return [motion](const Vector3d& place) {
    Point at;
    for (int axis = 0; axis < 3; ++axis) at[axis] = Number(place[axis], 3, axis);
    const Point moved = motion(at);
    PointMotion result;
    for (int axis = 0; axis < 3; ++axis) {
      result.move[axis] = moved[axis].value();
      result.gradient.row(axis) = moved[axis].derivatives();
    }
    return result;
  };
}

Point Constant(const Vector3d& vector) {
  Point point;
  for (int axis = 0; axis < 3; ++axis) point[axis] = Number(vector[axis], Vector3d::Zero());
  return point;
}

Number Along(const Point& from_origin, const Vector3d& axis) {
  return from_origin[0] * axis[0] + from_origin[1] * axis[1] + from_origin[2] * axis[2];
}

Point Times(const Vector3d& direction, const Number& by) {
  Point point;
  for (int axis = 0; axis < 3; ++axis) point[axis] = by * direction[axis];
  return point;
}

Point Scaled(const Point& point, const Number& by) {
  Point scaled;
  for (int axis = 0; axis < 3; ++axis) scaled[axis] = point[axis] * by;
  return scaled;
}

Number Zero() { return Number(0.0, Vector3d::Zero()); }
Number One() { return Number(1.0, Vector3d::Zero()); }

/// 0 before `from`, 1 after `to`, between 6t⁵ − 15t⁴ + 10t³: C2.
Number Step(const Number& x, double from, double to) {
  const Number t = (x - from) * (1.0 / (to - from));
  if (t.value() <= 0.0) return Zero();
  if (t.value() >= 1.0) return One();
  return t * t * t * (10.0 + t * (t * 6.0 - 15.0));
}

/// q² of a tool's footprint.
Number Footprint(const Point& from_origin, const ToolPlace& place) {
  const Vector3d across = place.out.cross(place.along);
  const Number a = Along(from_origin, place.along) * (1.0 / place.radius_along);
  const Number b = Along(from_origin, across) * (1.0 / place.radius_across);
  return a * a + b * b;
}

/// 1 within the tool's reach, 0 beyond twice that.
Number WithinReach(const Point& from_origin, const ToolPlace& place) {
  const Number height = Along(from_origin, place.out) * (1.0 / place.reach);
  return 1.0 - Step(height * height, 1.0, 4.0);
}

Number Power(const Number& base, int exponent) {
  Number power = One();
  for (int i = 0; i < exponent; ++i) power = power * base;
  return power;
}

/// 0 … 1 from one plane of a span to the other.
Number Progress(const Point& from_origin, const AxisSpan& span) {
  return Step(Along(from_origin, span.axis), 0.0, span.length);
}

Point Across(const Point& from_origin, const Vector3d& axis) {
  const Number height = Along(from_origin, axis);
  return from_origin - Times(axis, height);
}

}  // namespace

ClayField DentField(const ToolPlace& place, double depth) {
  return FieldOf([=](const Point& at) {
    const Point from = at - Constant(place.origin);
    const Number q2 = Footprint(from, place);
    if (q2.value() >= kBlendTo) return Constant(Vector3d::Zero());
    const Number shape = (1.0 - Step(q2, kBlendFrom, kBlendTo)) * (1.0 - Power(q2, place.flatness));
    return Times(place.out, shape * WithinReach(from, place) * (-depth));
  });
}

ClayField RimField(const ToolPlace& place, double rho) {
  const double rho2 = rho * rho;
  return FieldOf([=](const Point& at) {
    const Point from = at - Constant(place.origin);
    const Number q2 = Footprint(from, place);
    if (q2.value() <= kBlendFrom || q2.value() >= rho2) return Constant(Vector3d::Zero());
    const Number shape =
        Step(q2, kBlendFrom, kBlendTo) * (1.0 - q2 * (1.0 / rho2)) * (1.0 - Step(q2, kRimFades * rho2, rho2));
    return Times(place.out, shape * WithinReach(from, place));
  });
}

ClayField ScaleField(const Vector3d& centre) {
  return [centre](const Vector3d& at) { return PointMotion{at - centre, Eigen::Matrix3d::Identity()}; };
}

ClayField TwistField(const AxisSpan& span, double angle) {
  return FieldOf([=](const Point& at) {
    const Point from = at - Constant(span.origin);
    const Number turned = Progress(from, span) * angle;
    const Point across = Across(from, span.axis);
    const Point sideways = Constant(span.axis).cross(across);
    using std::cos;
    using std::sin;
    return Point(Scaled(across, cos(turned) - 1.0) + Scaled(sideways, sin(turned)));
  });
}

ClayField StretchField(const AxisSpan& span, double factor) {
  return FieldOf([=](const Point& at) {
    const Point from = at - Constant(span.origin);
    return Times(span.axis, Progress(from, span) * ((factor - 1.0) * span.length));
  });
}

ClayField GirthField(const AxisSpan& span) {
  const double soft = 0.2 * span.length;
  return FieldOf([=](const Point& at) {
    const Point from = at - Constant(span.origin);
    const Number height = Along(from, span.axis);
    const Number inside = Step(height, 0.0, soft) * (1.0 - Step(height, span.length - soft, span.length));
    return Scaled(Across(from, span.axis), inside);
  });
}

ClayField WidenField(const ToolPlace& place, double widening) {
  return FieldOf([=](const Point& at) {
    const Point from = at - Constant(place.origin);
    const Number q2 = Footprint(from, place);
    const Number share = (1.0 - Step(q2, 1.0, 4.0)) * WithinReach(from, place) * widening;
    return Scaled(Across(from, place.out), share);
  });
}

ClayField MakeRoomField(const ToolPlace& place, double widening) {
  constexpr double kFull = 1.25 * 1.25;
  return FieldOf([=](const Point& at) {
    const Point from = at - Constant(place.origin);
    const Number q2 = Footprint(from, place);
    Number share = (1.0 - Step(q2, 9.0, 36.0)) * WithinReach(from, place) * widening;
    if (q2.value() > kFull) {
      // 2a/t − (a/t)²: leaves 1 without a slope.
      const Number part = kFull / q2;
      share = share * part * (2.0 - part);
    }
    return Scaled(Across(from, place.out), share);
  });
}

ClayField BallField(const Vector3d& centre, double radius, double amount) {
  return FieldOf([=](const Point& at) {
    const Point from = at - Constant(centre);
    const Number square = from.dot(from);
    if (square.value() < 1e-12 * radius * radius) return Constant(Vector3d::Zero());
    using std::sqrt;
    return Scaled(from, (radius / sqrt(square) - 1.0) * amount);
  });
}

ClayField FlattenField(const ToolPlace& place, double amount) {
  return FieldOf([=](const Point& at) {
    const Point from = at - Constant(place.origin);
    const Number q2 = Footprint(from, place);
    const Number share = (1.0 - Step(q2, kBlendFrom, 2.0)) * WithinReach(from, place) * (-amount);
    return Times(place.out, Along(from, place.out) * share);
  });
}

ClayField ShaveField(const ToolPlace& place, double depth, double softness) {
  return FieldOf([=](const Point& at) {
    const Point from = at - Constant(place.origin);
    const Number above = Along(from, place.out) + depth;
    // 0 below −softness, `above` beyond +softness, between its square: C1.
    Number cut = Zero();
    if (above.value() >= softness) {
      cut = above;
    } else if (above.value() > -softness) {
      const Number t = above + softness;
      cut = t * t * (0.25 / softness);
    }
    const Number share = 1.0 - Step(Footprint(from, place), 1.0, 1.5);
    return Times(place.out, cut * share * WithinReach(from, place) * -1.0);
  });
}

ClayField KneadField(double amplitude, double wavelength, std::uint64_t seed) {
  constexpr std::size_t kWaves = 12;
  struct Wave {
    Vector3d number;  ///< rad/mm
    Vector3d swing;   ///< mm
    double phase = 0.0;
  };
  std::vector<Wave> waves(kWaves);
  std::mt19937_64 random(seed);
  // Not std::normal_distribution: its numbers differ between libraries.
  const auto even = [&random] { return static_cast<double>(random() >> 11U) * 0x1.0p-53; };
  const auto direction = [&even] {
    const double height = 2.0 * even() - 1.0;
    const double turn = 2.0 * std::numbers::pi * even();
    const double across = std::sqrt(1.0 - height * height);
    return Vector3d(across * std::cos(turn), across * std::sin(turn), height);
  };
  for (Wave& wave : waves) {
    wave.number = direction() * (2.0 * std::numbers::pi / wavelength);
    wave.swing = direction() * (amplitude / std::sqrt(static_cast<double>(kWaves)));
    wave.phase = 2.0 * std::numbers::pi * even();
  }
  return [waves](const Vector3d& at) {
    PointMotion motion;
    for (const Wave& wave : waves) {
      const double angle = wave.number.dot(at) + wave.phase;
      motion.move += std::sin(angle) * wave.swing;
      motion.gradient += std::cos(angle) * wave.swing * wave.number.transpose();
    }
    return motion;
  };
}

}  // namespace annulus
