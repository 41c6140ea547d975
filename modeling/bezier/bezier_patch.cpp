#include "modeling/bezier/bezier_patch.h"

#include <Eigen/Geometry>
#include <cstdint>
#include <vector>

#include "base/ensure.h"

namespace annulus {
namespace {

using Weights = std::array<double, 4>;

Weights BernsteinFirst(double t) {
  const double s = 1.0 - t;
  return {-3.0 * s * s, 3.0 * s * s - 6.0 * s * t, 6.0 * s * t - 3.0 * t * t, 3.0 * t * t};
}

Weights BernsteinSecond(double t) {
  const double s = 1.0 - t;
  return {6.0 * s, 6.0 * t - 12.0 * s, 6.0 * s - 12.0 * t, 6.0 * t};
}

Eigen::Vector3d Sum(const BezierPatch::ControlNet& net, const Weights& u, const Weights& v) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < 4; ++i) {
    for (std::size_t j = 0; j < 4; ++j) sum += u[i] * v[j] * net[i][j];
  }
  return sum;
}

/// Two cross products are taken for parallel below this sine.
constexpr double kParallel = 1e-9;

bool IsNormal(const Eigen::Vector3d& cross, double scale) { return cross.norm() > kParallel * scale && scale > 0.0; }

BezierPatch::ControlNet Transposed(const BezierPatch::ControlNet& net) {
  BezierPatch::ControlNet transposed;
  for (std::size_t i = 0; i < 4; ++i) {
    for (std::size_t j = 0; j < 4; ++j) transposed[j][i] = net[i][j];
  }
  return transposed;
}

}  // namespace

std::array<double, 4> CubicBernstein(double t) {
  const double s = 1.0 - t;
  return {s * s * s, 3.0 * s * s * t, 3.0 * s * t * t, t * t * t};
}

Eigen::Vector3d CubicBezierPoint(const BezierCurve& control, double t) {
  const Weights weight = CubicBernstein(t);
  return weight[0] * control[0] + weight[1] * control[1] + weight[2] * control[2] + weight[3] * control[3];
}

Eigen::Vector3d CubicBezierDerivative(const BezierCurve& control, double t) {
  const Weights weight = BernsteinFirst(t);
  return weight[0] * control[0] + weight[1] * control[1] + weight[2] * control[2] + weight[3] * control[3];
}

double CubicBezierLength(const BezierCurve& control) {
  constexpr int kPieces = 8;
  constexpr std::array<double, 3> kNodes{0.1127016653792583, 0.5, 0.8872983346207417};
  constexpr std::array<double, 3> kWeights{5.0 / 18.0, 8.0 / 18.0, 5.0 / 18.0};
  double length = 0.0;
  for (int piece = 0; piece < kPieces; ++piece) {
    for (std::size_t k = 0; k < kNodes.size(); ++k) {
      length += kWeights[k] / kPieces * CubicBezierDerivative(control, (piece + kNodes[k]) / kPieces).norm();
    }
  }
  return length;
}

BezierCurve Backwards(const BezierCurve& curve) { return {curve[3], curve[2], curve[1], curve[0]}; }

BezierCurve StraightCurve(const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
  return {from, (2.0 * from + to) / 3.0, (from + 2.0 * to) / 3.0, to};
}

std::pair<BezierCurve, BezierCurve> Split(const BezierCurve& p, double at) {
  const auto mix = [at](const Eigen::Vector3d& a, const Eigen::Vector3d& b) -> Eigen::Vector3d {
    return (1.0 - at) * a + at * b;
  };
  const Eigen::Vector3d p01 = mix(p[0], p[1]);
  const Eigen::Vector3d p12 = mix(p[1], p[2]);
  const Eigen::Vector3d p23 = mix(p[2], p[3]);
  const Eigen::Vector3d p012 = mix(p01, p12);
  const Eigen::Vector3d p123 = mix(p12, p23);
  const Eigen::Vector3d on_curve = mix(p012, p123);
  return {{p[0], p01, p012, on_curve}, {on_curve, p123, p23, p[3]}};
}

BezierPatch RuledPatch(const BezierCurve& first, const BezierCurve& last) {
  BezierPatch::ControlNet net;
  for (std::size_t i = 1; i < 3; ++i) {
    const double share = static_cast<double>(i) / 3.0;
    for (std::size_t j = 0; j < 4; ++j) net[i][j] = (1.0 - share) * first[j] + share * last[j];
  }
  net[0] = first;
  net[3] = last;
  return BezierPatch(net);
}

BezierPatch CoonsPatch(const PatchEdges& edges) {
  BezierPatch::ControlNet net;
  net[0] = edges.first_u;
  net[3] = edges.last_u;
  for (std::size_t i = 1; i < 3; ++i) {
    const double u = static_cast<double>(i) / 3.0;
    net[i][0] = edges.first_v[i];
    net[i][3] = edges.last_v[i];
    for (std::size_t j = 1; j < 3; ++j) {
      const double v = static_cast<double>(j) / 3.0;
      const Eigen::Vector3d along_u = (1.0 - v) * edges.first_v[i] + v * edges.last_v[i];
      const Eigen::Vector3d along_v = (1.0 - u) * edges.first_u[j] + u * edges.last_u[j];
      const Eigen::Vector3d corners = (1.0 - u) * ((1.0 - v) * edges.first_u[0] + v * edges.first_u[3]) +
                                      u * ((1.0 - v) * edges.last_u[0] + v * edges.last_u[3]);
      net[i][j] = along_u + along_v - corners;
    }
  }
  return BezierPatch(net);
}

Eigen::Vector3d BezierPatch::Point(double u, double v) const {
  return Sum(control_net_, CubicBernstein(u), CubicBernstein(v));
}

Eigen::Vector3d BezierPatch::PointByMatrix(double u, double v) const {
  Eigen::Matrix4d m;  // Eq. 4.
  m << 1, 0, 0, 0, -3, 3, 0, 0, 3, -6, 3, 0, -1, 3, -3, 1;
  const Eigen::RowVector4d u_powers(1.0, u, u * u, u * u * u);
  const Eigen::Vector4d v_powers(1.0, v, v * v, v * v * v);
  Eigen::Vector3d point;
  for (int axis = 0; axis < 3; ++axis) {
    Eigen::Matrix4d q;  // Eq. 5, one coordinate at a time.
    for (std::size_t i = 0; i < 4; ++i) {
      for (std::size_t j = 0; j < 4; ++j) {
        q(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) = control_net_[i][j][axis];
      }
    }
    point[axis] = u_powers * m * q * m.transpose() * v_powers;
  }
  return point;
}

Eigen::Vector3d BezierPatch::DerivativeU(double u, double v) const {
  return Sum(control_net_, BernsteinFirst(u), CubicBernstein(v));
}

Eigen::Vector3d BezierPatch::DerivativeV(double u, double v) const {
  return Sum(control_net_, CubicBernstein(u), BernsteinFirst(v));
}

Eigen::Vector3d BezierPatch::Normal(double u, double v) const {
  const Eigen::Vector3d s_u = DerivativeU(u, v);
  const Eigen::Vector3d s_v = DerivativeV(u, v);
  const Eigen::Vector3d cross = s_u.cross(s_v);
  if (IsNormal(cross, s_u.norm() * s_v.norm())) return cross.normalized();

  // S_u × S_v = 0 here: its first-order change on the way to the centre gives the limit of its direction.
  const double du = 0.5 - u;
  const double dv = 0.5 - v;
  const Eigen::Vector3d s_uv = Sum(control_net_, BernsteinFirst(u), BernsteinFirst(v));
  const Eigen::Vector3d change_u = du * Sum(control_net_, BernsteinSecond(u), CubicBernstein(v)) + dv * s_uv;
  const Eigen::Vector3d change_v = du * s_uv + dv * Sum(control_net_, CubicBernstein(u), BernsteinSecond(v));
  const Eigen::Vector3d limit = change_u.cross(s_v) + s_u.cross(change_v);
  if (IsNormal(limit, change_u.norm() * s_v.norm() + s_u.norm() * change_v.norm())) return limit.normalized();

  // Of higher order (a corner where both tangents vanish): look a little further in.
  constexpr double kStep = 1e-3;
  const double u_in = u + kStep * du;
  const double v_in = v + kStep * dv;
  const Eigen::Vector3d inner = DerivativeU(u_in, v_in).cross(DerivativeV(u_in, v_in));
  return inner.norm() > 0.0 ? inner.normalized() : Eigen::Vector3d::UnitZ();
}

std::pair<BezierPatch, BezierPatch> BezierPatch::Split(PatchDirection direction, double at) const {
  ENSURE(at > 0.0 && at < 1.0, "a patch is split inside");
  const ControlNet net = direction == PatchDirection::kV ? control_net_ : Transposed(control_net_);
  ControlNet low;
  ControlNet high;
  for (std::size_t i = 0; i < 4; ++i) std::tie(low[i], high[i]) = annulus::Split(net[i], at);
  if (direction == PatchDirection::kV) return {BezierPatch(low), BezierPatch(high)};
  return {BezierPatch(Transposed(low)), BezierPatch(Transposed(high))};
}

BezierCurve CurveAtU(const BezierPatch& patch, double u) {
  const Weights weight = CubicBernstein(u);
  const BezierPatch::ControlNet& q = patch.control_net();
  BezierCurve curve;
  for (std::size_t j = 0; j < 4; ++j) {
    curve[j] = weight[0] * q[0][j] + weight[1] * q[1][j] + weight[2] * q[2][j] + weight[3] * q[3][j];
  }
  return curve;
}

BezierCurve CurveChangeAtU(const BezierPatch& patch, double u) {
  const Weights weight = BernsteinFirst(u);
  const BezierPatch::ControlNet& q = patch.control_net();
  BezierCurve curve;
  for (std::size_t j = 0; j < 4; ++j) {
    curve[j] = weight[0] * q[0][j] + weight[1] * q[1][j] + weight[2] * q[2][j] + weight[3] * q[3][j];
  }
  return curve;
}

BezierPatch BezierPatch::Flipped() const { return BezierPatch(Transposed(control_net_)); }

BezierPatch BezierPatch::MirroredX() const {
  ControlNet net = Transposed(control_net_);
  for (auto& row : net) {
    for (Eigen::Vector3d& point : row) point.x() = -point.x();
  }
  return BezierPatch(net);
}

TriangleMesh Tessellate(const BezierPatch& patch, std::size_t count_u, std::size_t count_v) {
  ENSURE(count_u >= 1 && count_v >= 1, "a patch has at least one cell");
  TriangleMesh mesh;
  mesh.vertices.reserve((count_u + 1) * (count_v + 1));
  for (std::size_t i = 0; i <= count_u; ++i) {
    // The curve along v at this u: a quarter of the sums of Point.
    const BezierCurve along_v = CurveAtU(patch, static_cast<double>(i) / static_cast<double>(count_u));
    for (std::size_t j = 0; j <= count_v; ++j) {
      mesh.vertices.push_back(CubicBezierPoint(along_v, static_cast<double>(j) / static_cast<double>(count_v)));
    }
  }
  mesh.faces.reserve(2 * count_u * count_v);
  const auto index = [count_v](std::size_t i, std::size_t j) {
    return static_cast<std::uint32_t>(i * (count_v + 1) + j);
  };
  for (std::size_t i = 0; i < count_u; ++i) {
    for (std::size_t j = 0; j < count_v; ++j) {
      mesh.faces.push_back({index(i, j), index(i + 1, j), index(i + 1, j + 1)});
      mesh.faces.push_back({index(i, j), index(i + 1, j + 1), index(i, j + 1)});
    }
  }
  return mesh;
}

}  // namespace annulus
