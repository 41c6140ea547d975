#include "modeling/measure/paper_region.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <utility>
#include <vector>

#include "base/frames.h"

namespace annulus {
namespace {

constexpr double kCoplanar = 1e-6;  // mm: distance of D from plane ABC below which the four points are in one plane

/// A half space that keeps the region's side of a cut.
struct KeptSide {
  CuttingPlane plane;
  double sign = 1.0;  // of CuttingPlane::Height on the region's side

  [[nodiscard]] double Depth(const Eigen::Vector3d& p) const { return sign * plane.Height(p); }
};

/// The part of a polygon on the kept side; crossings by eqs. 3.2–3.4.
std::vector<Eigen::Vector3d> Clip(const std::vector<Eigen::Vector3d>& polygon, const KeptSide& side) {
  std::vector<Eigen::Vector3d> kept;
  for (std::size_t k = 0; k < polygon.size(); ++k) {
    const Eigen::Vector3d& low = polygon[k];
    const Eigen::Vector3d& high = polygon[(k + 1) % polygon.size()];
    const double from = side.Depth(low);
    const double to = side.Depth(high);
    if (from >= 0.0) kept.push_back(low);
    if ((from >= 0.0) != (to >= 0.0)) kept.push_back(low + from / (from - to) * (high - low));
  }
  return kept;
}

/// Sums of area and prism volumes over triangles.
class PrismSum {
 public:
  PrismSum(const CuttingPlane& plane_1, const Eigen::Vector3d& direction) : plane_1_(plane_1), direction_(direction) {}

  /// A polygon, counter-clockwise seen from outside, as a fan of triangles.
  void Add(const std::vector<Eigen::Vector3d>& polygon) {
    for (std::size_t k = 1; k + 1 < polygon.size(); ++k) {
      const std::array<Eigen::Vector3d, 3> corners{polygon[0], polygon[k], polygon[k + 1]};
      area_ += TriangleArea(corners);
      volume_ += PrismVolume(corners, direction_, plane_1_);
    }
  }
  [[nodiscard]] double area() const { return area_; }
  [[nodiscard]] double volume() const { return volume_; }

 private:
  CuttingPlane plane_1_;
  Eigen::Vector3d direction_;
  double area_ = 0.0;
  double volume_ = 0.0;
};

/// The closed polygon of both cuts in theta and z: over C to B, and over D back.
std::vector<SurfacePlace> Outline(const LatticePath& over_c, const LatticePath& over_d) {
  std::vector<SurfacePlace> outline;
  for (const PathPoint& p : over_c.points) outline.push_back(p.place);
  for (std::size_t k = over_d.points.size() - 1; k-- > 1;) outline.push_back(over_d.points[k].place);
  return outline;
}

double SignedArea(const std::vector<SurfacePlace>& outline) {
  double twice = 0.0;
  for (std::size_t k = 0; k < outline.size(); ++k) {
    const SurfacePlace& a = outline[k];
    const SurfacePlace& b = outline[(k + 1) % outline.size()];
    twice += (a.theta - outline[0].theta) * (b.z - outline[0].z) - (b.theta - outline[0].theta) * (a.z - outline[0].z);
  }
  return 0.5 * twice;
}

/// Angles at which the outline crosses the middle of a row of meshes, ascending.
std::vector<double> RowCrossings(const std::vector<SurfacePlace>& outline, double z) {
  std::vector<double> crossings;
  for (std::size_t k = 0; k < outline.size(); ++k) {
    const SurfacePlace& a = outline[k];
    const SurfacePlace& b = outline[(k + 1) % outline.size()];
    if ((a.z < z) == (b.z < z)) continue;
    crossings.push_back(a.theta + (z - a.z) / (b.z - a.z) * (b.theta - a.theta));
  }
  std::sort(crossings.begin(), crossings.end());
  return crossings;
}

/// Which cuts pass a mesh: by (level, angle).
using CutMeshes = std::map<std::pair<long, long>, std::array<bool, 2>>;

CutMeshes MeshesOf(const LatticePath& over_c, const LatticePath& over_d) {
  CutMeshes meshes;
  for (const LatticeCell& cell : over_c.cells) meshes[{cell.level, cell.angle}][0] = true;
  for (const LatticeCell& cell : over_d.cells) meshes[{cell.level, cell.angle}][1] = true;
  return meshes;
}

std::vector<Eigen::Vector3d> Corners(const PaperLattice& lattice, const LatticeCell& cell) {
  std::vector<Eigen::Vector3d> corners;
  for (const LatticeCell& corner : CornersOf(cell)) corners.push_back(lattice.Point(corner.angle, corner.level));
  return corners;
}

/// Adds the meshes of the region: cut ones by their part on the region's side, the others if their middle is inside.
void AddMeshes(const PaperLattice& lattice, const std::vector<SurfacePlace>& outline, const CutMeshes& cut,
               const std::array<KeptSide, 2>& sides, PrismSum& sum) {
  for (const auto& [at, by] : cut) {
    std::vector<Eigen::Vector3d> polygon = Corners(lattice, {at.second, at.first});
    for (std::size_t k = 0; k < 2; ++k) {
      if (by[k]) polygon = Clip(polygon, sides[k]);
    }
    sum.Add(polygon);
  }
  const auto [low, high] =
      std::minmax_element(outline.begin(), outline.end(), [](const auto& a, const auto& b) { return a.z < b.z; });
  const double width = kTwoPi / static_cast<double>(lattice.size().angles);
  for (long level = lattice.CellAt(*low).level; level <= lattice.CellAt(*high).level; ++level) {
    const double middle = 0.5 * (lattice.Place(0, level).z + lattice.Place(0, level + 1).z);
    const std::vector<double> crossings = RowCrossings(outline, middle);
    for (std::size_t k = 0; k + 1 < crossings.size(); k += 2) {
      for (long angle = std::lround(std::ceil(crossings[k] / width - 0.5));
           (static_cast<double>(angle) + 0.5) * width < crossings[k + 1]; ++angle) {
        if (!cut.contains({level, angle})) sum.Add(Corners(lattice, {angle, level}));
      }
    }
  }
}

/// Turns the way over D so that it begins at the same theta as the other.
void Align(const PaperLattice& lattice, const LatticePath& over_c, LatticePath& over_d) {
  const double turns = std::round((over_c.points.front().place.theta - over_d.points.front().place.theta) / kTwoPi);
  for (PathPoint& p : over_d.points) p.place.theta += turns * kTwoPi;
  for (LatticeCell& cell : over_d.cells) {
    cell.angle += static_cast<long>(turns) * static_cast<long>(lattice.size().angles);
  }
}

/// The region's side of a cut that is walked from A to B; `sense` 1 if the region is on the left.
KeptSide SideOf(const LatticePath& path, double sense) {
  return {path.clicked.plane(), path.direction == CutDirection::kPlusLeft ? sense : -sense};
}

}  // namespace

double TriangleArea(const std::array<Eigen::Vector3d, 3>& corners) {
  return 0.5 * (corners[1] - corners[0]).cross(corners[2] - corners[0]).norm();
}

Eigen::Vector3d ProjectionDirection(const Eigen::Vector3d& normal_1, const Eigen::Vector3d& normal_2) {
  return (normal_1.dot(normal_2) * normal_2 - normal_2.squaredNorm() * normal_1).normalized();
}

double PrismVolume(const std::array<Eigen::Vector3d, 3>& corners, const Eigen::Vector3d& direction,
                   const CuttingPlane& plane) {
  double lengths = 0.0;  // l + m + n: along `direction` to the plane (eq. 3.8)
  for (const Eigen::Vector3d& corner : corners) lengths -= plane.Height(corner) / plane.normal.dot(direction);
  const double section = -0.5 * direction.dot((corners[1] - corners[0]).cross(corners[2] - corners[0]));  // eq. 3.9
  return lengths / 3.0 * section;
}

Result<PaperRegion> RegionOnLattice(const MeasuredSurface& body, const RegionClicks& clicks, LatticeSize size) {
  const std::string attempted = "cut a region by the planes ABC and ABD over the meshes of the lattice";
  const Click a{"A", clicks.a};
  const Click b{"B", clicks.b};
  auto over_c = LatticeCut(body, size, {a, {"C", clicks.c}, b});
  if (!over_c) return Fail(over_c);
  auto over_d = LatticeCut(body, size, {a, {"D", clicks.d}, b});
  if (!over_d) return Fail(over_d);
  const CuttingPlane plane_1 = over_c->clicked.plane();
  const CuttingPlane plane_2 = over_d->clicked.plane();
  if (std::abs(plane_1.Height(over_d->clicked.corner(2))) < kCoplanar ||
      std::abs(plane_2.Height(over_c->clicked.corner(2))) < kCoplanar) {
    return Fail(attempted, "A, B, C and D lie in one plane", "move C or D, so that the planes enclose something");
  }
  const PaperLattice lattice(body.surface(), size);
  Align(lattice, *over_c, *over_d);
  if (std::abs(over_c->points.back().place.theta - over_d->points.back().place.theta) > 1e-6) {
    return Fail(attempted, "the cuts over C and D go around the body and enclose no region",
                "choose C and D so that both cuts go from A to B on one side of the body");
  }
  const std::vector<SurfacePlace> outline = Outline(*over_c, *over_d);
  const double sense = SignedArea(outline) < 0.0 ? -1.0 : 1.0;
  const std::array<KeptSide, 2> sides{SideOf(*over_c, sense), SideOf(*over_d, -sense)};
  const Eigen::Vector3d direction =
      ProjectionDirection(sides[0].sign * plane_1.normal, plane_2.normal);  // n1 towards the region
  PrismSum sum(plane_1, direction);
  AddMeshes(lattice, outline, MeshesOf(*over_c, *over_d), sides, sum);
  return PaperRegion{sum.area(), sum.volume(), std::move(*over_c), std::move(*over_d)};
}

}  // namespace annulus
