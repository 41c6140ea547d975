#include "modeling/clay/patch_volume.h"

#include <Eigen/Geometry>
#include <array>
#include <cstddef>

namespace annulus {
namespace {

using Eigen::Vector3d;
using ControlNet = BezierPatch::ControlNet;

constexpr std::size_t kNodes = 5;

/// Gauss–Legendre on [0, 1], and there the Bernstein polynomials and their derivatives.
struct Rule {
  std::array<double, kNodes> weight{0.118463442528094544, 0.239314335249683234, 0.284444444444444444,
                                    0.239314335249683234, 0.118463442528094544};
  std::array<std::array<double, 4>, kNodes> value{};
  std::array<std::array<double, 4>, kNodes> slope{};
};

const Rule& GaussRule() {
  static const Rule rule = [] {
    constexpr std::array<double, kNodes> kAt{0.0469100770306680036, 0.230765344947158454, 0.5, 0.769234655052841546,
                                             0.953089922969331996};
    Rule made;
    for (std::size_t n = 0; n < kNodes; ++n) {
      const double t = kAt[n];
      const double s = 1.0 - t;
      made.value[n] = CubicBernstein(t);
      made.slope[n] = {-3.0 * s * s, 3.0 * s * (s - 2.0 * t), 3.0 * t * (2.0 * s - t), 3.0 * t * t};
    }
    return made;
  }();
  return rule;
}

/// Σ weight_i · curve_i.
Vector3d Blend(const std::array<double, 4>& weight, const std::array<Vector3d, 4>& curve) {
  return weight[0] * curve[0] + weight[1] * curve[1] + weight[2] * curve[2] + weight[3] * curve[3];
}

/// Control points of S(u, ·) for weights B_i(u), of S_u(u, ·) for weights B_i'(u).
std::array<Vector3d, 4> Across(const std::array<double, 4>& weight, const ControlNet& net) {
  std::array<Vector3d, 4> curve;
  for (std::size_t j = 0; j < 4; ++j) {
    curve[j] = weight[0] * net[0][j] + weight[1] * net[1][j] + weight[2] * net[2][j] + weight[3] * net[3][j];
  }
  return curve;
}

/// R, R_u and R_v at one node.
struct Jet {
  Vector3d point, along_u, along_v;
};

/// Calls `use(weight, jet of each net)` at all nodes.
template <std::size_t N, class Use>
void ForEachNode(const std::array<const ControlNet*, N>& nets, Use use) {
  const Rule& rule = GaussRule();
  for (std::size_t i = 0; i < kNodes; ++i) {
    std::array<std::array<Vector3d, 4>, N> curve;
    std::array<std::array<Vector3d, 4>, N> change;
    for (std::size_t n = 0; n < N; ++n) {
      curve[n] = Across(rule.value[i], *nets[n]);
      change[n] = Across(rule.slope[i], *nets[n]);
    }
    for (std::size_t j = 0; j < kNodes; ++j) {
      std::array<Jet, N> jet;
      for (std::size_t n = 0; n < N; ++n) {
        jet[n] = {Blend(rule.value[j], curve[n]), Blend(rule.value[j], change[n]), Blend(rule.slope[j], curve[n])};
      }
      use(rule.weight[i] * rule.weight[j], jet);
    }
  }
}

}  // namespace

double ConeVolume(const ControlNet& net, const Vector3d& apex) {
  double six = 0.0;
  ForEachNode<1>({&net}, [&](double weight, const std::array<Jet, 1>& jet) {
    six += weight * (jet[0].point - apex).dot(jet[0].along_u.cross(jet[0].along_v));
  });
  return six / 3.0;
}

Cubic ConeVolumeAlong(const ControlNet& net, const ControlNet& direction, const Vector3d& apex) {
  Cubic cubic;
  ForEachNode<2>({&net, &direction}, [&](double weight, const std::array<Jet, 2>& jet) {
    const Vector3d point = weight * (jet[0].point - apex);
    const Vector3d change = weight * jet[1].point;
    const Vector3d constant = jet[0].along_u.cross(jet[0].along_v);
    const Vector3d linear = jet[0].along_u.cross(jet[1].along_v) + jet[1].along_u.cross(jet[0].along_v);
    const Vector3d square = jet[1].along_u.cross(jet[1].along_v);
    cubic.c[0] += point.dot(constant);
    cubic.c[1] += point.dot(linear) + change.dot(constant);
    cubic.c[2] += point.dot(square) + change.dot(linear);
    cubic.c[3] += change.dot(square);
  });
  for (double& c : cubic.c) c /= 3.0;
  return cubic;
}

double PatchArea(const ControlNet& net) {
  double area = 0.0;
  ForEachNode<1>({&net}, [&](double weight, const std::array<Jet, 1>& jet) {
    area += weight * jet[0].along_u.cross(jet[0].along_v).norm();
  });
  return area;
}

}  // namespace annulus
