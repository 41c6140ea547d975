#include "modeling/elastic/elastic_loads.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "modeling/mesh/convex_hull_2d.h"

namespace annulus {
namespace {

using Eigen::Vector3d;

constexpr std::size_t kFinePoints = 720;  ///< Of the real skin's outline: its polygon is short by 3e-6.
constexpr std::size_t kMostFibres = 25;

/// The plane n · p = offset with its directions.
struct BandPlane {
  Vector3d normal;
  double offset = 0.0;
  Eigen::Matrix<double, 2, 3> directions;
};

BandPlane PlaneOf(const SurfaceSegment& segment, const BandLoad& band, double shift) {
  const Eigen::Vector2d axis = segment.axis.At(band.z);
  BandPlane plane;
  plane.normal = band.normal;
  plane.offset = band.normal.dot(Vector3d(axis.x(), axis.y(), band.z)) + shift;
  const Vector3d x = (Vector3d::UnitX() - band.normal.x() * band.normal).normalized();
  plane.directions.row(0) = x.transpose();
  plane.directions.row(1) = band.normal.cross(x).transpose();
  return plane;
}

/// The height at which the plane cuts the skin in a direction; nothing outside the segment. By bisection: a lowest and
/// a highest point on either side are enough.
std::optional<double> HeightOn(const SurfaceSegment& segment, const BandPlane& plane, double theta) {
  const auto above = [&](double z) { return plane.normal.dot(segment.Point(theta, z)) - plane.offset; };
  double low = segment.surface.z_min();
  double high = segment.surface.z_max();
  if (!(above(low) <= 0.0 && above(high) >= 0.0)) return std::nullopt;
  if (plane.normal == Vector3d::UnitZ()) return plane.offset;
  for (int n = 0; n < 60 && high - low > 1e-10; ++n) {
    const double middle = 0.5 * (low + high);
    (above(middle) <= 0.0 ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

Error LeftTheBody(const BandLoad& band) {
  return {"lay a band around the body", fmt::format("at z {:g} mm it leaves the region or the segment", band.z),
          "give a band within the heights of the region"};
}

/// The real skin's tape length in a plane.
Result<double> TapeIn(const SurfaceSegment& segment, const BandPlane& plane, const BandLoad& band) {
  std::vector<Eigen::Vector2d> outline;
  for (std::size_t k = 0; k < kFinePoints; ++k) {
    const double theta = kTwoPi * static_cast<double>(k) / static_cast<double>(kFinePoints);
    const auto z = HeightOn(segment, plane, theta);
    if (!z) return tl::unexpected<Error>(LeftTheBody(band));
    outline.emplace_back(plane.directions * segment.Point(theta, *z));
  }
  return ConvexHullPerimeter(outline);
}

/// A thread's point on a column of nodes: where the polyline through its skin nodes meets the plane.
std::optional<FibrePoint> PointOnColumn(const ElasticRegion& region, const BandPlane& plane, std::size_t column) {
  const GridShape& shape = region.grid.shape;
  for (std::size_t j = 0; j + 1 < shape.rows; ++j) {
    const std::size_t stack = j * shape.columns + column;
    const Vector3d& below = region.grid.nodes[region.SkinNode(stack)];
    const Vector3d& upper = region.grid.nodes[region.SkinNode(stack + shape.columns)];
    const double from = plane.normal.dot(below) - plane.offset;
    const double to = plane.normal.dot(upper) - plane.offset;
    if (!(from <= 0.0 && to > 0.0)) continue;
    const double share = from / (from - to);
    return FibrePoint{stack, share, (1.0 - share) * below + share * upper};
  }
  return std::nullopt;
}

Result<BandFibre> FibreIn(const ElasticRegion& region, const SurfaceSegment& segment, const BandPlane& plane,
                          const BandLoad& band) {
  BandFibre fibre;
  fibre.plane = plane.directions;
  const GridShape& shape = region.grid.shape;
  for (std::size_t i = 0; i < shape.columns; ++i) {
    const auto point = PointOnColumn(region, plane, i);
    if (!point) return tl::unexpected<Error>(LeftTheBody(band));
    fibre.points.push_back(*point);
  }
  if (shape.closure == GridClosure::kOpen) {
    const double rest = kTwoPi - (region.theta.back() - region.theta.front());
    const auto steps = static_cast<std::size_t>(std::ceil(rest / (region.theta[1] - region.theta[0])));
    for (std::size_t k = 1; k < steps; ++k) {
      const double theta = region.theta.back() + rest * static_cast<double>(k) / static_cast<double>(steps);
      const auto z = HeightOn(segment, plane, theta);
      if (!z) return tl::unexpected<Error>(LeftTheBody(band));
      fibre.points.push_back({FibrePoint::kFixed, 0.0, segment.Point(theta, *z)});
    }
  }
  const auto tape = TapeIn(segment, plane, band);
  if (!tape) return Fail(tape);
  std::vector<Vector3d> rest;
  for (const FibrePoint& point : fibre.points) rest.push_back(point.rest);
  fibre.length_factor = *tape / HullLength(fibre, rest);
  return fibre;
}

/// Shares of a bump on the skin nodes that can move.
std::vector<double> SharesOf(const ElasticRegion& region, const SurfaceSegment& segment, const SkinBump& bump) {
  const Vector3d centre = segment.Point(bump.theta, bump.z);
  std::vector<double> shares(region.grid.shape.stacks(), 0.0);
  for (std::size_t stack = 0; stack < shares.size(); ++stack) {
    if (region.OnRim(stack)) continue;
    shares[stack] = bump.ShareAt((region.grid.nodes[region.SkinNode(stack)] - centre).norm());
  }
  return shares;
}

}  // namespace

Status AddLoad(const ElasticRegion& region, const SurfaceSegment& segment, const BumpLoad& load,
               ElasticProblem& problem) {
  const std::vector<double> shares = SharesOf(region, segment, load.bump);
  double total = 0.0;
  double squares = 0.0;
  for (std::size_t stack = 0; stack < shares.size(); ++stack) {
    total += shares[stack] * region.area[stack];
    squares += shares[stack] * shares[stack] * region.area[stack];
  }
  if (!(squares > 0.0)) {
    return Fail("load the skin",
                fmt::format("within {:g} mm of theta {:g} deg, z {:g} mm no node of the region can move",
                            load.bump.radius, load.bump.theta * 360.0 / kTwoPi, load.bump.z),
                "give a place in the region, or a radius_mm above its spacing_mm");
  }
  if (load.as == BumpLoad::As::kDisplacement) {
    for (std::size_t stack = 0; stack < shares.size(); ++stack) {
      if (!(shares[stack] > 0.0)) continue;
      const std::size_t node = region.SkinNode(stack);
      problem.given[node] += load.bump.outward * shares[stack] * region.normal[stack];
      for (std::size_t c = 0; c < 3; ++c) problem.held[3 * node + c] = 1;
    }
    return {};
  }
  NodePull pull;
  const bool force = load.as == BumpLoad::As::kForce;
  for (std::size_t stack = 0; stack < shares.size(); ++stack) {
    if (!(shares[stack] > 0.0)) continue;
    const double weight = shares[stack] * region.area[stack] / (force ? total : squares);
    pull.entries.push_back({region.SkinNode(stack), weight * region.normal[stack]});
  }
  pull.force = load.force;
  if (!force) pull.movement = load.bump.outward;
  problem.pulls.push_back(std::move(pull));
  return {};
}

Result<std::vector<BandFibre>> FibresOf(const ElasticRegion& region, const SurfaceSegment& segment,
                                        const BandLoad& band) {
  const double row = region.z[1] - region.z[0];
  // An odd number: one lies in the middle plane, in which the band's girth is told. No closer than rows of nodes, which
  // could not follow them all.
  const double pairs = std::clamp(std::floor(0.5 * (band.width / row - 1.0)), 0.0, 0.5 * (kMostFibres - 1));
  const std::size_t count = 2 * static_cast<std::size_t>(pairs) + 1;
  std::vector<BandFibre> fibres;
  for (std::size_t n = 0; n < count; ++n) {
    const double share = (static_cast<double>(n) + 0.5) / static_cast<double>(count);
    auto fibre = FibreIn(region, segment, PlaneOf(segment, band, (share - 0.5) * band.width), band);
    if (!fibre) return Fail(fibre);
    fibre->width = band.width / static_cast<double>(count);
    fibre->target = band.girth;
    fibre->rest_length = band.rest_length;
    fibre->stiffness = band.stiffness / static_cast<double>(count);
    fibres.push_back(std::move(*fibre));
  }
  return fibres;
}

Result<double> GirthUnder(const SurfaceSegment& segment, const BandLoad& band) {
  return TapeIn(segment, PlaneOf(segment, band, 0.0), band);
}

}  // namespace annulus
