#include "modeling/glasses/lens_thickness.h"

#include <array>
#include <cmath>
#include <limits>

#include "base/units.h"

namespace annulus {
namespace {

double Cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

/// A node of Gauss–Legendre quadrature on [0, 1].
struct GaussNode {
  double at;
  double weight;
};
/// Six nodes from the box centre outwards: exact for polynomials of degree 11.
constexpr std::array<GaussNode, 6> kRadial{{{0.033765242898423975, 0.08566224618958517},
                                            {0.16939530676686774, 0.1803807865240693},
                                            {0.3806904069584015, 0.23395696728634552},
                                            {0.6193095930415985, 0.23395696728634552},
                                            {0.8306046932331322, 0.1803807865240693},
                                            {0.966234757101576, 0.08566224618958517}}};
/// Two along the outline's side.
constexpr std::array<GaussNode, 2> kAlong{{{0.21132486540518713, 0.5}, {0.7886751345948129, 0.5}}};

}  // namespace

LensEdge EdgeOf(const LensForm& form, const LensOutline& outline, std::size_t count) {
  const std::vector<double> radii = RadiiOf(outline, count);
  const Eigen::Vector2d centre = BoxOf(outline).centre;
  LensEdge edge;
  edge.points.reserve(count);
  edge.thinnest = std::numeric_limits<double>::infinity();
  edge.thickest = -std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < count; ++i) {
    EdgePoint point;
    point.angle = kTwoPi * static_cast<double>(i) / static_cast<double>(count);
    point.position = centre + radii[i] * Eigen::Vector2d(std::cos(point.angle), std::sin(point.angle));
    point.front_z = form.front.Sag(point.position.x(), point.position.y());
    point.back_z = form.back.Sag(point.position.x(), point.position.y());
    const double thickness = point.thickness();
    if (thickness < edge.thinnest) {
      edge.thinnest = thickness;
      edge.thinnest_angle = point.angle;
    }
    if (thickness > edge.thickest) {
      edge.thickest = thickness;
      edge.thickest_angle = point.angle;
    }
    edge.points.push_back(point);
  }
  return edge;
}

LensBody BodyOf(const LensForm& form, const LensOutline& outline, double density) {
  const Eigen::Vector2d centre = BoxOf(outline).centre;
  LensBody body;
  Eigen::Vector3d moment = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < outline.points.size(); ++i) {
    const Eigen::Vector2d a = outline.points[i] - centre;
    const Eigen::Vector2d b = outline.points[i + 1 == outline.points.size() ? 0 : i + 1] - centre;
    const double twice_area = Cross(a, b);
    for (const GaussNode& radial : kRadial) {
      for (const GaussNode& along : kAlong) {
        // (r, s) → centre + r·(a + s·(b − a)), Jacobian r·(a × b).
        const Eigen::Vector2d p = centre + radial.at * (a + along.at * (b - a));
        const double area = radial.at * twice_area * radial.weight * along.weight;
        const double front = form.front.Sag(p.x(), p.y());
        const double back = form.back.Sag(p.x(), p.y());
        const double column = area * (front - back);
        body.volume += column;
        moment += column * Eigen::Vector3d(p.x(), p.y(), 0.5 * (front + back));
      }
    }
  }
  body.centre_of_gravity = moment / body.volume;
  body.weight = body.volume * density / 1000.0;  // mm³ → cm³
  return body;
}

ThicknessMap ThicknessMapOf(const LensForm& form, const LensOutline& outline, double step) {
  const LensBox box = BoxOf(outline);
  ThicknessMap map;
  map.x0 = box.centre.x() - box.a / 2.0;
  map.y0 = box.centre.y() - box.b / 2.0;
  map.step = step;
  const auto columns = static_cast<Eigen::Index>(std::floor(box.a / step)) + 1;
  const auto rows = static_cast<Eigen::Index>(std::floor(box.b / step)) + 1;
  map.thickness.setConstant(rows, columns, std::numeric_limits<double>::quiet_NaN());
  for (Eigen::Index row = 0; row < rows; ++row) {
    for (Eigen::Index column = 0; column < columns; ++column) {
      const Eigen::Vector2d p(map.x0 + static_cast<double>(column) * step, map.y0 + static_cast<double>(row) * step);
      if (Inside(outline, p)) map.thickness(row, column) = form.Thickness(p.x(), p.y());
    }
  }
  return map;
}

bool Inside(const LensOutline& outline, const Eigen::Vector2d& point) {
  bool inside = false;
  for (std::size_t i = 0; i < outline.points.size(); ++i) {
    const Eigen::Vector2d a = outline.points[i] - point;
    const Eigen::Vector2d b = outline.points[i + 1 == outline.points.size() ? 0 : i + 1] - point;
    if ((a.y() > 0.0) == (b.y() > 0.0)) continue;
    // The side crosses the horizontal through the point: to its right?
    if (Cross(a, b) * (b.y() - a.y()) > 0.0) inside = !inside;
  }
  return inside;
}

}  // namespace annulus
