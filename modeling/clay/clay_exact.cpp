#include "modeling/clay/clay_exact.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "modeling/measure/gauss.h"

namespace annulus {
namespace {

using Eigen::Vector3d;
using ControlNet = BezierPatch::ControlNet;

/// Four control points of one span of a uniform cubic B-spline as those of the same cubic's Bezier form.
BezierCurve SpanAsBezier(const BezierCurve& q) {
  return {(q[0] + 4.0 * q[1] + q[2]) / 6.0, (2.0 * q[1] + q[2]) / 3.0, (q[1] + 2.0 * q[2]) / 3.0,
          (q[1] + 4.0 * q[2] + q[3]) / 6.0};
}

/// Span [column, column + 1] × [row, row + 1]: knot line i is Q_{i-1}, Q_i, Q_{i+1} around, Q_i … Q_{i+2} upwards.
ControlNet NetOfSpan(const PaperSurface& surface, std::size_t column, std::size_t row) {
  const std::size_t columns = surface.theta_knots().size();
  std::array<BezierCurve, 4> along;  // by control column, in Bezier form upwards
  for (std::size_t i = 0; i < 4; ++i) {
    BezierCurve upwards;
    for (std::size_t j = 0; j < 4; ++j) {
      upwards[j] = surface.control()[(row + j) * columns + (column + columns - 1 + i) % columns];
    }
    along[i] = SpanAsBezier(upwards);
  }
  ControlNet net;
  for (std::size_t j = 0; j < 4; ++j) {
    const BezierCurve around = SpanAsBezier({along[0][j], along[1][j], along[2][j], along[3][j]});
    for (std::size_t i = 0; i < 4; ++i) net[i][j] = around[i];
  }
  return net;
}

/// A flat piece from a wall's edge to the axis.
ShellPatch CapOf(const ControlNet& wall, std::size_t j) {
  BezierCurve edge;
  BezierCurve middle;
  for (std::size_t i = 0; i < 4; ++i) {
    edge[i] = wall[i][j];
    middle[i] = Vector3d(0.0, 0.0, edge[i].z());
  }
  const BezierPatch piece = RuledPatch(edge, middle);
  return {j == 0 ? piece : piece.Flipped(), PatchDetail::kAlong, PatchDetail::kAlong};
}

std::vector<double> Whole(std::size_t count) {
  std::vector<double> numbers;
  for (std::size_t n = 0; n <= count; ++n) numbers.push_back(static_cast<double>(n));
  return numbers;
}

/// ∫ ½∮(x y_u − y x_u) du z_v dv over the spans, mm³: four Gauss nodes miss nothing but the eighth power of v, of which
/// quarters of a span leave less than 1e-10.
double VolumeOf(const PaperSurface& surface) {
  std::vector<double> quarters = Whole(4 * (surface.z_knots().size() - 1));
  for (double& v : quarters) v *= 0.25;
  const std::vector<QuadratureNode> around = PiecewiseGauss(Whole(surface.theta_knots().size()));
  double volume = 0.0;
  for (const QuadratureNode& v : PiecewiseGauss(quarters)) {
    for (const QuadratureNode& u : around) {
      const SurfacePartials at = surface.Partials({u.x, v.x});
      volume += 0.5 * (at.point.x() * at.u.y() - at.point.y() * at.u.x()) * at.v.z() * u.weight * v.weight;
    }
  }
  return volume;
}

}  // namespace

Result<ClayOfSurface> ClayFromPaper(const PaperSurface& surface, const std::string& name) {
  const std::size_t columns = surface.theta_knots().size();
  const std::size_t rows = surface.z_knots().size() - 1;
  PatchShell shell{name, {}};
  double error = 0.0;
  for (std::size_t n = 0; n < columns * rows; ++n) {
    const std::size_t column = n % columns;
    const std::size_t row = n / columns;
    const BezierPatch patch(NetOfSpan(surface, column, row));
    const auto middle = SurfaceParameters{static_cast<double>(column) + 0.3, static_cast<double>(row) + 0.6};
    error = std::max(error, (patch.Point(0.3, 0.6) - surface.PointAt(middle)).norm());
    shell.patches.push_back({patch, PatchDetail::kAlong, PatchDetail::kAlong});
  }
  const std::size_t last = columns * (rows - 1);
  for (std::size_t i = 0; i < columns; ++i) {
    shell.patches.push_back(CapOf(shell.patches[i].patch.control_net(), 0));
  }
  for (std::size_t i = 0; i < columns; ++i) {
    shell.patches.push_back(CapOf(shell.patches[last + i].patch.control_net(), 3));
  }
  auto body = ClayBody::Make(shell);
  if (!body) return Fail(body);
  const double volume_error = body->volume() / VolumeOf(surface) - 1.0;
  return ClayOfSurface{std::move(*body), error, volume_error, columns, rows};
}

Result<PatchShell> FramePart(const Frame& frame, std::string_view name) {
  PatchShell whole{name.empty() ? "frame" : std::string(name), {}};
  if (name == "lens_right" || name == "lens_left") {
    whole.patches.push_back({name == "lens_right" ? frame.lens_right : frame.lens_left});
    return whole;
  }
  std::string names;
  PatchShell of_body = whole;
  for (const FrameBody& body : FrameBodies(frame)) {
    names += (names.empty() ? "" : ", ") + body.name;
    for (const PatchShell& shell : body.shells) {
      names += ", " + shell.name;
      PatchShell* to = name.empty() || name == shell.name ? &whole : name == body.name ? &of_body : nullptr;
      if (to != nullptr) to->patches.insert(to->patches.end(), shell.patches.begin(), shell.patches.end());
    }
  }
  if (whole.patches.empty()) whole = std::move(of_body);
  if (!whole.patches.empty()) return whole;
  return Fail(fmt::format("take part '{}' of a frame", name), "it has no such part", "use one of " + names);
}

}  // namespace annulus
