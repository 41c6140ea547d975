#include "modeling/flatten/surface_region.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <unordered_map>

#include "modeling/flatten/geodesic_side.h"

namespace annulus {
namespace {

using Eigen::Vector2d;

constexpr std::size_t kMostTriangles = 200'000;
/// Steps of the first grid and its distance from the lines, over the element's size.
constexpr double kGridStep = 0.75;
constexpr double kGridMargin = 0.55;
constexpr double kRadToDeg = 180.0 / std::numbers::pi;

tl::unexpected<Error> Refuse(std::string seen, const char* advice) {
  return Fail("fill the region with triangles", std::move(seen), advice);
}

Status CheckPlaces(const SurfaceSegment& segment, const RegionLines& lines) {
  const double low = segment.surface.z_min();
  const double high = segment.surface.z_max();
  for (const Vector2d& place : lines.points) {
    if (place.allFinite() && place.y() >= low && place.y() <= high) continue;
    return Refuse(fmt::format("the place theta {:.1f} deg, z {:.1f} mm is outside the surface, z = {:.1f} … {:.1f} mm",
                              kRadToDeg * place.x(), place.y(), low, high),
                  "keep the pattern's lines on what was scanned");
  }
  return {};
}

double DistanceToSegment(const Vector2d& p, const Vector2d& a, const Vector2d& b) {
  const Vector2d along = b - a;
  const double t = std::clamp((p - a).dot(along) / std::max(along.squaredNorm(), 1e-300), 0.0, 1.0);
  return (p - a - t * along).norm();
}

bool IsInside(const Vector2d& p, const std::vector<Vector2d>& points, std::size_t count) {
  bool inside = false;
  for (std::size_t i = 0, j = count - 1; i < count; j = i++) {
    const Vector2d& a = points[i];
    const Vector2d& b = points[j];
    if ((a.y() > p.y()) != (b.y() > p.y()) && p.x() < (b.x() - a.x()) * (p.y() - a.y()) / (b.y() - a.y()) + a.x()) {
      inside = !inside;
    }
  }
  return inside;
}

/// Adds a grid of equilateral triangles' corners that keeps clear of all lines; the lines are in the plane.
Status AddGrid(RegionLines& plane, double element_mm) {
  Eigen::Array2d low = plane.points.front();
  Eigen::Array2d high = low;
  for (const Vector2d& p : plane.points) {
    low = low.min(p.array());
    high = high.max(p.array());
  }
  const double step = kGridStep * element_mm;
  const double row_step = 0.5 * std::sqrt(3.0) * step;
  if (!((high - low).prod() / (step * row_step) < static_cast<double>(kMostTriangles))) {
    return Refuse(fmt::format("elements of {:g} mm are too small for it", element_mm), "take larger elements");
  }
  const std::vector<Vector2d> given = plane.points;
  const auto clear = [&](const Vector2d& p) {
    const double margin = kGridMargin * element_mm;
    for (std::size_t k = 0; k < plane.rim_count; ++k) {
      if (DistanceToSegment(p, given[k], given[(k + 1) % plane.rim_count]) < margin) return false;
    }
    for (std::size_t k = plane.rim_count; k < given.size(); ++k) {  // chains are as fine as the elements
      if ((p - given[k]).norm() < margin) return false;
    }
    return true;
  };
  bool odd = false;
  for (double y = low.y() + row_step; y < high.y(); y += row_step, odd = !odd) {
    for (double x = low.x() + (odd ? 0.5 : 1.0) * step; x < high.x(); x += step) {
      const Vector2d p(x, y);
      if (IsInside(p, given, plane.rim_count) && clear(p)) plane.points.push_back(p);
    }
  }
  return {};
}

CurvedSheet SheetOver(const SurfaceSegment& segment, const PlaneMesh& mesh, const std::vector<Vector2d>& theta_z) {
  CurvedSheet sheet;
  for (const Vector2d& place : theta_z) sheet.places.push_back(segment.Point(place.x(), place.y()));
  std::unordered_map<std::uint64_t, double> known;
  for (const PlaneMesh::Triangle& triangle : mesh.triangles()) {
    std::array<double, 3> lengths{};
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t a = std::min(triangle.vertex[k], triangle.vertex[(k + 1) % 3]);
      const std::uint32_t b = std::max(triangle.vertex[k], triangle.vertex[(k + 1) % 3]);
      const auto [at, is_new] = known.try_emplace((std::uint64_t{a} << 32U) | b, 0.0);
      if (is_new) at->second = GeodesicSide(segment, theta_z[a], theta_z[b]);
      lengths[k] = at->second;
    }
    sheet.faces.push_back(triangle.vertex);
    sheet.lengths.push_back(lengths);
  }
  return sheet;
}

Status CheckSeen(const SurfaceSegment& segment, const std::vector<Vector2d>& theta_z) {
  if (segment.knowledge.columns() * segment.knowledge.rows() <= 1) return {};
  for (const Vector2d& place : theta_z) {
    if (segment.knowledge.At(place.x(), place.y()) != Knowledge::kUnknown) continue;
    return Refuse(fmt::format("at theta {:.1f} deg, z {:.1f} mm nothing was seen", kRadToDeg * place.x(), place.y()),
                  "keep the pattern's lines on what was scanned (annulus eval says what was), or scan again");
  }
  return {};
}

}  // namespace

double TurnedArea(const std::vector<Vector2d>& chain) {
  double area = 0.0;
  for (std::size_t k = 0; k < chain.size(); ++k) {
    const Vector2d& a = chain[k];
    const Vector2d& b = chain[(k + 1) % chain.size()];
    area += a.x() * b.y() - a.y() * b.x();
  }
  return area;
}

Result<RegionSheet> FillRegion(const SurfaceSegment& segment, const RegionLines& lines, double element_mm) {
  if (!(element_mm > 0.0) || lines.rim_count < 3 || lines.points.size() > kMostTriangles) {
    return Refuse(fmt::format("{} rim points and elements of {:g} mm", lines.rim_count, element_mm),
                  "give three rim points or more and a size over 0");
  }
  RETURN_IF_ERROR(CheckPlaces(segment, lines));
  double radius = 0.0;
  for (std::size_t k = 0; k < lines.rim_count; ++k) {
    radius += segment.surface.Radius(lines.points[k].x(), lines.points[k].y()) / static_cast<double>(lines.rim_count);
  }
  if (!(radius > 0.0)) return Refuse("the surface has no radius there", "check the model");
  RegionLines plane = lines;
  for (Vector2d& p : plane.points) p.x() *= radius;
  plane.held_count = plane.points.size();
  RETURN_IF_ERROR(AddGrid(plane, element_mm));
  auto mesh = PlaneMesh::Fill(plane);
  if (!mesh) return Fail(mesh);
  const auto lift = [&](const Vector2d& p) { return segment.Point(p.x() / radius, p.y()); };
  RETURN_IF_ERROR(mesh->Refine(lift, element_mm, kMostTriangles));
  RegionSheet region;
  for (const Vector2d& p : mesh->points()) region.theta_z.emplace_back(p.x() / radius, p.y());
  for (std::size_t k = 0; k < lines.points.size(); ++k) region.theta_z[k] = lines.points[k];
  RETURN_IF_ERROR(CheckSeen(segment, region.theta_z));
  region.sheet = SheetOver(segment, *mesh, region.theta_z);
  return region;
}

}  // namespace annulus
