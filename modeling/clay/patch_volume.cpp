#include "modeling/clay/patch_volume.h"

#include <Eigen/Geometry>
#include <array>
#include <cstddef>

namespace annulus {
namespace {

using Eigen::Vector3d;
using ControlNet = BezierPatch::ControlNet;

constexpr std::size_t kNodes = 5;
/// The nodes along v side by side, and one of no weight that makes them even: the processor takes two at once.
using Lane = Eigen::Array<double, 6, 1>;

/// Gauss–Legendre on [0, 1], and there the Bernstein polynomials and their derivatives.
struct Rule {
  std::array<double, kNodes> weight{0.118463442528094544, 0.239314335249683234, 0.284444444444444444,
                                    0.239314335249683234, 0.118463442528094544};
  std::array<std::array<double, 4>, kNodes> value{};
  std::array<std::array<double, 4>, kNodes> slope{};
  Lane weights = Lane::Zero();
  std::array<Lane, 4> values;
  std::array<Lane, 4> slopes;
};

const Rule& GaussRule() {
  static const Rule rule = [] {
    constexpr std::array<double, kNodes> kAt{0.0469100770306680036, 0.230765344947158454, 0.5, 0.769234655052841546,
                                             0.953089922969331996};
    Rule made;
    made.values.fill(Lane::Zero());
    made.slopes.fill(Lane::Zero());
    for (std::size_t n = 0; n < kNodes; ++n) {
      const double t = kAt[n];
      const double s = 1.0 - t;
      made.value[n] = CubicBernstein(t);
      made.slope[n] = {-3.0 * s * s, 3.0 * s * (s - 2.0 * t), 3.0 * t * (2.0 * s - t), 3.0 * t * t};
      const auto at = static_cast<Eigen::Index>(n);
      made.weights[at] = made.weight[n];
      for (std::size_t b = 0; b < 4; ++b) {
        made.values[b][at] = made.value[n][b];
        made.slopes[b][at] = made.slope[n][b];
      }
    }
    return made;
  }();
  return rule;
}

/// The control points of a curve along v, all coordinates of each.
using Curve = Eigen::Array<double, 12, 1>;

/// Of S(u, ·) for weights B_i(u), of S_u(u, ·) for weights B_i'(u).
Curve Across(const std::array<double, 4>& weight, const ControlNet& net) {
  const auto row = [&net](std::size_t i) { return Eigen::Map<const Curve>(net[i][0].data()); };
  return weight[0] * row(0) + weight[1] * row(1) + weight[2] * row(2) + weight[3] * row(3);
}

/// A vector at each node along v.
struct LaneVector {
  Lane x, y, z;

  [[nodiscard]] LaneVector Cross(const LaneVector& other) const {
    return {y * other.z - z * other.y, z * other.x - x * other.z, x * other.y - y * other.x};
  }
  [[nodiscard]] Lane Dot(const LaneVector& other) const { return x * other.x + y * other.y + z * other.z; }
  [[nodiscard]] LaneVector Plus(const LaneVector& other) const { return {x + other.x, y + other.y, z + other.z}; }
};

LaneVector Along(const std::array<Lane, 4>& weight, const Curve& curve) {
  const auto coordinate = [&](Eigen::Index c) -> Lane {
    return curve[c] * weight[0] + curve[3 + c] * weight[1] + curve[6 + c] * weight[2] + curve[9 + c] * weight[3];
  };
  return {coordinate(0), coordinate(1), coordinate(2)};
}

/// R, R_u and R_v at the nodes of one u.
struct Jet {
  LaneVector point, along_u, along_v;
};

Jet JetAt(const Rule& rule, std::size_t i, const ControlNet& net) {
  const Curve curve = Across(rule.value[i], net);
  return {Along(rule.values, curve), Along(rule.values, Across(rule.slope[i], net)), Along(rule.slopes, curve)};
}

LaneVector From(const LaneVector& point, const Vector3d& apex) {
  return {point.x - apex.x(), point.y - apex.y(), point.z - apex.z()};
}

}  // namespace

double ConeVolume(const ControlNet& net, const Vector3d& apex) {
  const Rule& rule = GaussRule();
  Lane six = Lane::Zero();
  for (std::size_t i = 0; i < kNodes; ++i) {
    const Jet jet = JetAt(rule, i, net);
    six += rule.weight[i] * From(jet.point, apex).Dot(jet.along_u.Cross(jet.along_v));
  }
  return (rule.weights * six).sum() / 3.0;
}

Cubic ConeVolumeAlong(const ControlNet& net, const ControlNet& direction, const Vector3d& apex) {
  const Rule& rule = GaussRule();
  std::array<Lane, 4> sum;
  sum.fill(Lane::Zero());
  for (std::size_t i = 0; i < kNodes; ++i) {
    const Jet at = JetAt(rule, i, net);
    const Jet along = JetAt(rule, i, direction);
    const LaneVector point = From(at.point, apex);
    const LaneVector constant = at.along_u.Cross(at.along_v);
    const LaneVector linear = at.along_u.Cross(along.along_v).Plus(along.along_u.Cross(at.along_v));
    const LaneVector square = along.along_u.Cross(along.along_v);
    sum[0] += rule.weight[i] * point.Dot(constant);
    sum[1] += rule.weight[i] * (point.Dot(linear) + along.point.Dot(constant));
    sum[2] += rule.weight[i] * (point.Dot(square) + along.point.Dot(linear));
    sum[3] += rule.weight[i] * along.point.Dot(square);
  }
  Cubic cubic;
  for (std::size_t n = 0; n < 4; ++n) cubic.c[n] = (rule.weights * sum[n]).sum() / 3.0;
  return cubic;
}

double PatchArea(const ControlNet& net) {
  const Rule& rule = GaussRule();
  Lane area = Lane::Zero();
  for (std::size_t i = 0; i < kNodes; ++i) {
    const Jet jet = JetAt(rule, i, net);
    const LaneVector normal = jet.along_u.Cross(jet.along_v);
    area += rule.weight[i] * normal.Dot(normal).sqrt();
  }
  return (rule.weights * area).sum();
}

}  // namespace annulus
