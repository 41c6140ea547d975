#include "modeling/measure/plane_cut.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

#include "base/frames.h"
#include "modeling/measure/cut_path.h"
#include "modeling/measure/gauss.h"
#include "modeling/measure/number_text.h"
#include "modeling/measure/paper_lattice.h"
#include "modeling/measure/unresolved_length.h"
#include "modeling/mesh/convex_hull_2d.h"

namespace annulus {
namespace {

constexpr double kOnEdge = 1e-9;  // mm: a point nearer to an edge is on it

PathPoint Wrapped(PathPoint point) {
  point.place.theta = WrapAngle(point.place.theta);
  return point;
}

/// The way as a path whose ends are clicked places: they move along their rays, the rest in the plane.
std::vector<PathPoint> AsPath(const SplineSurface& surface, const CutPath& path) {
  std::vector<PathPoint> points;
  for (const CutNode& node : path.nodes) points.push_back(Wrapped(path.curve.InPlane({node.theta, node.z})));
  points.front() = RadialPoint(surface, points.front().place);
  points.back() = RadialPoint(surface, points.back().place);
  return points;
}

Result<SurfaceDistance> MeasurePath(const MeasuredSurface& body, const CutPath& path, const std::string& attempted) {
  SurfaceDistance distance;
  distance.path = AsPath(body.surface(), path);
  distance.knowledge = KnowledgeAlong(body, distance.path, PathEnds::kOpen);
  RETURN_IF_ERROR(CheckKnown(distance.knowledge, attempted));
  std::vector<PathPoint> in_plane;
  for (const CutNode& node : path.nodes) in_plane.push_back(path.curve.InPlane({node.theta, node.z}));
  Estimate length = ClickedLength(body.surface(), path.clicked, distance.path);
  length.value = path.curve.Length(path.nodes);
  distance.length = WithUnresolved(length, UnresolvedLength(body, in_plane, PathEnds::kOpen));
  return distance;
}

/// Heights at which the plane crosses the meridian theta = 0: between samples, four in every knot interval.
std::vector<double> CrossingsOfMeridian(const SplineSurface& surface, const CuttingPlane& plane) {
  const auto height = [&](double z) { return plane.Height(surface.Point(0.0, z)); };
  const std::vector<double>& breaks = surface.z_basis().breakpoints();
  std::vector<double> crossings;
  double low = breaks.front();
  for (std::size_t j = 0; j + 1 < breaks.size(); ++j) {
    for (int part = 1; part <= 4; ++part) {
      const double high = part == 4 ? breaks[j + 1] : breaks[j] + 0.25 * part * (breaks[j + 1] - breaks[j]);
      double a = low;
      double b = high;
      if ((height(a) < 0.0) != (height(b) < 0.0)) {
        const bool below = height(a) < 0.0;
        for (int k = 0; k < 60; ++k) {
          const double middle = 0.5 * (a + b);
          ((height(middle) < 0.0) == below ? a : b) = middle;
        }
        crossings.push_back(0.5 * (a + b));
      }
      low = high;
    }
  }
  return crossings;
}

/// Whether the loop passes the meridian theta = 0 at this height.
bool Passes(const CutWalk& loop, double z) {
  return std::any_of(loop.nodes.begin(), loop.nodes.end(), [&](const CutNode& node) {
    return std::abs(AngleDifference(node.theta, 0.0)) < 1e-9 && std::abs(node.z - z) < 1e-6;
  });
}

double TurnsAround(const CutWalk& loop) {
  return std::round((loop.nodes.back().theta - loop.nodes.front().theta) / kTwoPi);
}

/// The one loop around the axis, counter-clockwise about it. Every such loop crosses the meridian theta = 0.
Result<CutWalk> LoopAround(const SplineSurface& surface, const CutCurve& curve, const CuttingPlane& plane) {
  const std::string attempted = "measure the girth in a plane";
  std::vector<CutWalk> loops;
  std::optional<CutWalk> broken;
  for (const double z : CrossingsOfMeridian(surface, plane)) {
    if (std::any_of(loops.begin(), loops.end(), [&](const CutWalk& loop) { return Passes(loop, z); })) continue;
    CutWalk walk = curve.Walk({0.0, z}, CutDirection::kPlusLeft, {});
    if (walk.end != CutEnd::kBackAtStart) {
      if (!broken) broken = std::move(walk);
      continue;
    }
    if (TurnsAround(walk) < 0.0) walk = curve.Walk({0.0, z}, CutDirection::kPlusRight, {});
    if (walk.end == CutEnd::kBackAtStart) loops.push_back(std::move(walk));
  }
  const auto around = std::count_if(loops.begin(), loops.end(), [](const CutWalk& l) { return TurnsAround(l) != 0.0; });
  if (around > 1) {
    return Fail(attempted, "the plane makes " + std::to_string(around) + " loops around the axis",
                "choose a plane with less tilt");
  }
  if (around == 0) {
    if (broken) return tl::unexpected(WalkError(*broken, "its beginning again", attempted));
    return Fail(attempted, "the plane does not go around the body within the scanned range",
                "choose a plane with less tilt or at another height");
  }
  return *std::find_if(loops.begin(), loops.end(), [](const CutWalk& l) { return TurnsAround(l) != 0.0; });
}

/// The plane's own coordinates: x × y is the side of the normal that points up.
struct FlatFrame {
  Eigen::Vector3d x;
  Eigen::Vector3d y;

  explicit FlatFrame(const CuttingPlane& plane) {
    const Eigen::Vector3d up = plane.normal.z() < 0.0 ? Eigen::Vector3d(-plane.normal) : plane.normal;
    x = up.unitOrthogonal();
    y = up.cross(x);
  }
  [[nodiscard]] Eigen::Vector2d Flat(const Eigen::Vector3d& p) const { return {x.dot(p), y.dot(p)}; }
};

/// The hull of the loop. Where two corners follow each other on the loop, the tape lies on the skin between them.
/// How much longer the loop is between two successive corners of its hull than their chord; 0 where the tape spans a
/// hollow. The hull leaves out points that are on an edge to the bit.
double OnSkin(const CutCurve& curve, std::span<const CutNode> nodes, std::size_t from, std::size_t to) {
  const std::size_t count = nodes.size() - 1;  // the last is the first again
  const Eigen::Vector3d chord = nodes[to].position - nodes[from].position;
  double length = 0.0;
  for (std::size_t k = from; k != to; k = (k + 1) % count) {
    const Eigen::Vector3d arm = nodes[k].position - nodes[from].position;
    if (arm.cross(chord).norm() > kOnEdge * chord.norm()) return 0.0;
    length += curve.Length(nodes.subspan(k, 2));
  }
  return length - chord.norm();
}

struct Tape {
  Estimate length;
  std::vector<PathPoint> corners;
};

Tape TapeAround(const SplineSurface& surface, const CutCurve& curve, std::span<const CutNode> nodes,
                const std::vector<PathPoint>& loop) {
  const FlatFrame frame(curve.plane());
  std::vector<std::pair<Eigen::Vector2d, std::size_t>> by_place;
  std::vector<Eigen::Vector2d> flat;
  for (std::size_t k = 0; k < loop.size(); ++k) {
    flat.push_back(frame.Flat(loop[k].position));
    by_place.emplace_back(flat.back(), k);
  }
  const auto before = [](const auto& a, const auto& b) {
    return std::pair(a.first.x(), a.first.y()) < std::pair(b.first.x(), b.first.y());
  };
  std::sort(by_place.begin(), by_place.end(), before);
  std::vector<std::size_t> corner;  // indices of the hull's corners, which are points of the loop to the bit
  for (const Eigen::Vector2d& p : ConvexHull(flat)) {
    corner.push_back(std::lower_bound(by_place.begin(), by_place.end(), std::pair(p, std::size_t{0}), before)->second);
  }
  Tape tape;
  double on_skin = 0.0;
  for (std::size_t k = 0; k < corner.size(); ++k) {
    tape.corners.push_back(loop[corner[k]]);
    const std::size_t next = corner[(k + 1) % corner.size()];
    on_skin += OnSkin(curve, nodes, corner[k], next);
  }
  tape.length = PolygonLength(surface, tape.corners, PathEnds::kClosed);
  tape.length.value += on_skin;
  return tape;
}

/// How much longer the tape is on average around the surfaces that the returns allow than around their mean: over the
/// body's deviations and their mirror images, like UnresolvedHullLength.
double UnresolvedTape(const MeasuredSurface& body, const FlatFrame& frame, const std::vector<PathPoint>& loop) {
  const std::vector<Eigen::VectorXd>& deviations = body.Deviations();
  if (deviations.empty()) return 0.0;
  std::vector<RadiusRow> rows;
  std::vector<Eigen::Vector2d> fitted;
  for (const PathPoint& point : loop) {
    rows.push_back(body.surface().Row(point.place.theta, point.place.z));
    fitted.push_back(frame.Flat(point.position));
  }
  double sum = 0.0;
  std::vector<Eigen::Vector2d> moved(loop.size());
  for (const Eigen::VectorXd& deviation : deviations) {
    for (const double mirror : {-1.0, 1.0}) {
      for (std::size_t k = 0; k < loop.size(); ++k) {
        double by = 0.0;
        for (std::size_t i = 0; i < rows[k].index.size(); ++i) {
          by += rows[k].value[i] * deviation[static_cast<Eigen::Index>(rows[k].index[i])];
        }
        moved[k] = fitted[k] + mirror * by * frame.Flat(loop[k].by_radius);
      }
      sum += ConvexHullPerimeter(moved);
    }
  }
  return sum / (2.0 * static_cast<double>(deviations.size())) - ConvexHullPerimeter(fitted);
}

Estimate AreaWithin(const SplineSurface& surface, const CutCurve& curve, std::span<const CutNode> nodes) {
  const FlatFrame frame(curve.plane());
  const Eigen::Vector2d centre = frame.Flat(nodes.front().position);
  GradientSum gradient(surface);
  double area = 0.0;
  for (std::size_t k = 0; k + 1 < nodes.size(); ++k) {
    for (const QuadratureNode& at : PiecewiseGauss(std::array<double, 2>{0.0, 1.0})) {
      const CutSample s = curve.Between(nodes[k], nodes[k + 1], at.x);
      const Eigen::Vector2d p = frame.Flat(s.position) - centre;
      const Eigen::Vector2d by_t = frame.Flat(s.by_t);
      area += at.weight * 0.5 * (p.x() * by_t.y() - p.y() * by_t.x());
      const Eigen::Vector2d move = frame.Flat(curve.InPlane({s.theta, s.z}).by_radius);
      gradient.AddRadius(s.theta, s.z, at.weight * (move.x() * by_t.y() - move.y() * by_t.x()));
    }
  }
  return {area, gradient.Get()};
}

}  // namespace

Result<SurfaceDistance> DistanceByPlane(const MeasuredSurface& body, const SurfacePlace& from, const SurfacePlace& via,
                                        const SurfacePlace& to, CutMethod method) {
  const Click first{"the first point", from};
  const Click middle{"the point between", via};
  const Click last{"the last point", to};
  if (method == CutMethod::kPaper) {
    return LatticeDistance(body, LatticeCut(body, PaperLattice::SizeOfScan(body), {first, middle, last}));
  }
  const auto path = CutThrough(body, first, middle, last);
  if (!path) return Fail(path);
  return MeasurePath(body, *path, "measure along a plane");
}

Result<SurfaceDistance> DistanceByView(const MeasuredSurface& body, const SurfacePlace& from, const SurfacePlace& to,
                                       const Eigen::Vector3d& view, CutMethod method) {
  const Click first{"the first point", from};
  const Click last{"the last point", to};
  if (method == CutMethod::kPaper) {
    return LatticeDistance(body, LatticeViewCut(body, PaperLattice::SizeOfScan(body), {first, last}, view));
  }
  const auto path = CutInView(body, first, last, view);
  if (!path) return Fail(path);
  return MeasurePath(body, *path, "measure along a plane of sight");
}

Result<TiltedGirth> GirthInPlane(const MeasuredSurface& body, const CuttingPlane& plane) {
  const std::string attempted = "measure the girth in a plane";
  if (!plane.normal.allFinite() || !std::isfinite(plane.offset) || std::abs(plane.normal.norm() - 1.0) > 1e-9) {
    return Fail(attempted, "the plane's normal is not a finite unit vector", "give a direction of length 1");
  }
  const SplineSurface& surface = body.surface();
  const CutCurve curve(surface, plane);
  const auto walk = LoopAround(surface, curve, plane);
  if (!walk) return Fail(walk);
  TiltedGirth girth;
  for (std::size_t k = 0; k + 1 < walk->nodes.size(); ++k) {
    girth.loop.push_back(Wrapped(curve.InPlane({walk->nodes[k].theta, walk->nodes[k].z})));
  }
  girth.knowledge = KnowledgeAlong(body, girth.loop, PathEnds::kClosed);
  RETURN_IF_ERROR(CheckKnown(girth.knowledge, attempted));
  Estimate perimeter = PolygonLength(surface, girth.loop, PathEnds::kClosed);
  perimeter.value = curve.Length(walk->nodes);
  girth.perimeter = WithUnresolved(perimeter, UnresolvedLength(body, girth.loop, PathEnds::kClosed));
  Tape tape = TapeAround(surface, curve, walk->nodes, girth.loop);
  girth.tape = WithUnresolved(tape.length, UnresolvedTape(body, FlatFrame(plane), girth.loop));
  girth.tape_path = std::move(tape.corners);
  girth.area = AreaWithin(surface, curve, walk->nodes);
  return girth;
}

}  // namespace annulus
