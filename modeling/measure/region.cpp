#include "modeling/measure/region.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

#include "base/frames.h"
#include "modeling/measure/gauss.h"
#include "modeling/measure/place_check.h"
#include "modeling/measure/region_knowledge.h"
#include "modeling/measure/region_quadrature.h"

namespace annulus {
namespace {

constexpr double kCoplanar = 1e-6;   // mm: distance of D from plane ABC below which the four points are in one plane
constexpr double kSamePlace = 1e-3;  // mm: two crossings of the line AB nearer than this are one

/// The places inside a way (not at its ends) where it crosses the other plane: on the line AB.
std::vector<SurfacePlace> CrossingsOf(const SplineSurface& surface, const CutPath& path, const CuttingPlane& other) {
  std::vector<SurfacePlace> crossings;
  for (std::size_t k = 1; k + 2 < path.nodes.size(); ++k) {
    const CutNode& from = path.nodes[k];
    const CutNode& to = path.nodes[k + 1];
    const double height = other.Height(from.position);
    if ((height < 0.0) == (other.Height(to.position) < 0.0)) continue;
    const double t = height / (height - other.Height(to.position));
    Eigen::Vector2d at(from.theta + t * (to.theta - from.theta), from.z + t * (to.z - from.z));
    for (int step = 0; step < 6; ++step) {  // Newton: on both planes
      const RadiusJet jet = surface.Jet(at.x(), at.y());
      const Eigen::Vector3d outward(std::cos(at.x()), std::sin(at.x()), 0.0);
      const Eigen::Vector3d around(-outward.y(), outward.x(), 0.0);
      const Eigen::Vector3d p = jet.r * outward + at.y() * Eigen::Vector3d::UnitZ();
      const Eigen::Vector3d by_theta = jet.r_theta * outward + jet.r * around;
      const Eigen::Vector3d by_z = jet.r_z * outward + Eigen::Vector3d::UnitZ();
      const Eigen::Vector3d& n = path.clicked.plane().normal;
      Eigen::Matrix2d slope;
      slope << n.dot(by_theta), n.dot(by_z), other.normal.dot(by_theta), other.normal.dot(by_z);
      const Eigen::Vector2d miss(path.clicked.plane().Height(p), other.Height(p));
      if (std::abs(slope.determinant()) < 1e-12) break;
      at -= slope.inverse() * miss;
    }
    crossings.push_back({at.x(), at.y()});
  }
  return crossings;
}

std::optional<SurfacePlace> CommonPlace(const SplineSurface& surface, const RegionBoundary& boundary) {
  const auto one = CrossingsOf(surface, boundary.over_c, boundary.over_d.clicked.plane());
  if (one.empty()) return std::nullopt;
  const auto two = CrossingsOf(surface, boundary.over_d, boundary.over_c.clicked.plane());
  for (const SurfacePlace& a : one) {
    for (const SurfacePlace& b : two) {
      const double apart = (surface.Point(a.theta, a.z) - surface.Point(b.theta, b.z)).norm();
      if (apart < kSamePlace) return a;
    }
  }
  return std::nullopt;
}

/// The boundary as a closed polygon in theta and z, from A over C to B and over D back.
std::vector<SurfacePlace> Polygon(const RegionBoundary& boundary) {
  std::vector<SurfacePlace> polygon;
  for (const CutNode& node : boundary.over_c.nodes) polygon.push_back({node.theta, node.z});
  const std::vector<CutNode>& back = boundary.over_d.nodes;
  for (std::size_t k = back.size() - 1; k-- > 1;) polygon.push_back({back[k].theta, back[k].z});
  return polygon;
}

/// 1 if the polygon runs counter-clockwise in (theta, z), seen from outside; else -1.
double Orientation(const std::vector<SurfacePlace>& polygon) {
  double twice = 0.0;
  const SurfacePlace& at = polygon.front();
  for (std::size_t k = 1; k + 1 < polygon.size(); ++k) {
    twice += (polygon[k].theta - at.theta) * (polygon[k + 1].z - at.z) -
             (polygon[k + 1].theta - at.theta) * (polygon[k].z - at.z);
  }
  return twice < 0.0 ? -1.0 : 1.0;
}

/// Where the boundary crosses the upper edge of a strip.
struct EdgeCrossings {
  std::vector<double> down;  // theta of crossings into the strip
  std::vector<double> up;    // and out of it
};

/// By strip. `orientation` 1: downward crossings are left ends of what lies inside, upward ones right ends.
std::vector<EdgeCrossings> CrossingsOfStrips(const ClampedCubicBasis& z_basis,
                                             const std::vector<SurfacePlace>& polygon) {
  const std::size_t count = polygon.size();
  const auto strip_from = [&](std::size_t k) {
    return z_basis.Interval(0.5 * (polygon[k % count].z + polygon[(k + 1) % count].z));
  };
  std::vector<EdgeCrossings> crossings(z_basis.breakpoints().size() - 1);
  for (std::size_t k = 0; k < count; ++k) {
    const std::size_t before = strip_from(k + count - 1);
    const std::size_t after = strip_from(k);
    for (std::size_t j = before; j < after; ++j) crossings[j].up.push_back(polygon[k].theta);
    for (std::size_t j = after; j < before; ++j) crossings[j].down.push_back(polygon[k].theta);
  }
  return crossings;
}

/// The integrals over the region and how they follow the planes' corners.
class RegionIntegrals {
 public:
  RegionIntegrals(const SplineSurface& surface, const RegionBoundary& boundary)
      : surface_(&surface), boundary_(&boundary), sums_(surface, boundary.over_c.clicked.corner(0)) {
    const std::vector<SurfacePlace> polygon = Polygon(boundary);
    orientation_ = Orientation(polygon);
    AddStrips(polygon);
    area_moved_ = Eigen::Matrix<double, 3, 2>::Zero();
    volume_moved_ = area_moved_;
    AddWay(boundary.over_c, orientation_, 0);
    AddWay(boundary.over_d, -orientation_, 1);
  }

  [[nodiscard]] Estimate Area() const { return {sums_.skin(), WithPlanes(sums_.SkinGradient(), area_moved_)}; }
  [[nodiscard]] Estimate Volume() const { return {sums_.volume(), WithPlanes(sums_.VolumeGradient(), volume_moved_)}; }

 private:
  /// Strip by strip: what lies below the parts of its upper edge that are inside; AddWay corrects to the boundary.
  void AddStrips(const std::vector<SurfacePlace>& polygon) {
    std::vector<EdgeCrossings> strips = CrossingsOfStrips(surface_->z_basis(), polygon);
    for (std::size_t j = 0; j < strips.size(); ++j) {
      auto& left = orientation_ > 0.0 ? strips[j].down : strips[j].up;
      auto& right = orientation_ > 0.0 ? strips[j].up : strips[j].down;
      std::sort(left.begin(), left.end());
      std::sort(right.begin(), right.end());
      for (std::size_t k = 0; k < std::min(left.size(), right.size()); ++k) {
        if (left[k] < right[k]) sums_.AddRectangle(j, left[k], right[k]);
      }
    }
  }

  /// A way from A to B; `sense` 1 if it is walked counter-clockwise around the region. Green's theorem in its strips:
  /// ∬ f = -∮ dtheta ∫ f dz from the strip's lower edge.
  void AddWay(const CutPath& path, double sense, Eigen::Index plane) {
    const Eigen::Vector3d& normal = path.clicked.plane().normal;
    const Eigen::Vector3d& apex = path.clicked.corner(0);
    const std::vector<QuadratureNode> unit = PiecewiseGauss(std::array<double, 2>{0.0, 1.0});
    for (std::size_t k = 0; k + 1 < path.nodes.size(); ++k) {
      const CutNode& from = path.nodes[k];
      const CutNode& to = path.nodes[k + 1];
      const std::size_t strip = surface_->z_basis().Interval(0.5 * (from.z + to.z));
      for (const QuadratureNode& at : unit) {
        const CutSample s = path.curve.Between(from, to, at.x);
        const SurfacePlace place{s.theta, s.z};
        const double weight = sense * at.weight;
        sums_.AddColumn(strip, place, -weight * s.theta_by_t);
        // The cut moves over the skin so that its height over the plane stays zero.
        const double by_height = -weight * sums_.SkinDensity(place) *
                                 (s.height_by_theta * s.z_by_t - s.height_by_z * s.theta_by_t) /
                                 (s.height_by_theta * s.height_by_theta + s.height_by_z * s.height_by_z) *
                                 std::min(1.0, s.sine_squared / (kLimitedSine * kLimitedSine));
        const double lift = normal.x() * std::cos(s.theta) + normal.y() * std::sin(s.theta);
        sums_.AddSkinByRadius(place, by_height * lift);
        area_moved_.col(plane) -= by_height * path.clicked.Shares(s.position);
        // The lid in the plane is swept along its normal: triangles from A, moved as at their centroids.
        const Eigen::Vector3d arm = s.position - apex;
        volume_moved_.col(plane) -=
            0.5 * weight * normal.dot(arm.cross(s.by_t)) * path.clicked.Shares(apex + 2.0 / 3.0 * arm);
      }
    }
  }

  [[nodiscard]] Gradient WithPlanes(const Gradient& at_rest, const Eigen::Matrix<double, 3, 2>& moved) const {
    GradientSum gradient(*surface_);
    gradient.Add(at_rest, 1.0);
    boundary_->over_c.clicked.AddMovement(moved.col(0), gradient);
    boundary_->over_d.clicked.AddMovement(moved.col(1), gradient);
    return gradient.Get();
  }

  const SplineSurface* surface_;
  const RegionBoundary* boundary_;
  RegionQuadrature sums_;
  double orientation_ = 1.0;
  Eigen::Matrix<double, 3, 2> area_moved_;  // derivatives by the corners of either plane, along its normal
  Eigen::Matrix<double, 3, 2> volume_moved_;
};

std::vector<PathPoint> AsPath(const CutPath& path) {
  std::vector<PathPoint> points;
  for (const CutNode& node : path.nodes) points.push_back(path.curve.InPlane({WrapAngle(node.theta), node.z}));
  return points;
}

}  // namespace

Result<RegionBoundary> CutRegion(const MeasuredSurface& body, const RegionClicks& clicks) {
  const std::string attempted = "cut a region by the planes ABC and ABD";
  const Click a{"A", clicks.a};
  const Click b{"B", clicks.b};
  auto over_c = CutThrough(body, a, {"C", clicks.c}, b);
  if (!over_c) return Fail(over_c);
  const auto second = ClickedPlane::Through(body, {a, b, {"D", clicks.d}});
  if (!second) return Fail(second);
  if (std::abs(over_c->clicked.plane().Height(second->corner(2))) < kCoplanar ||
      std::abs(second->plane().Height(over_c->clicked.corner(2))) < kCoplanar) {
    return Fail(attempted, "A, B, C and D lie in one plane", "move C or D, so that the planes enclose something");
  }
  auto over_d = CutThrough(body, a, {"D", clicks.d}, b);
  if (!over_d) return Fail(over_d);
  RegionBoundary boundary{std::move(*over_c), std::move(*over_d)};
  std::vector<CutNode>& other = boundary.over_d.nodes;
  const double turns = std::round((boundary.over_c.nodes.front().theta - other.front().theta) / kTwoPi);
  for (CutNode& node : other) node.theta += turns * kTwoPi;
  if (std::abs(boundary.over_c.nodes.back().theta - other.back().theta) > 1e-6) {
    return Fail(attempted, "the cuts over C and D go around the body and enclose no region",
                "choose C and D so that both cuts go from A to B on one side of the body");
  }
  if (const auto common = CommonPlace(body.surface(), boundary)) {
    return Fail(attempted, "the cuts over C and D cross at " + PlaceText(*common), "choose A and B nearer together");
  }
  return boundary;
}

Result<RegionEstimates> RegionBetween(const MeasuredSurface& body, const RegionClicks& clicks) {
  const auto boundary = CutRegion(body, clicks);
  if (!boundary) return Fail(boundary);
  RegionEstimates region;
  region.knowledge = KnowledgeWithin(body, Polygon(*boundary));
  RETURN_IF_ERROR(CheckKnown(region.knowledge, "measure the region between the planes ABC and ABD"));
  const RegionIntegrals integrals(body.surface(), *boundary);
  region.area = integrals.Area();
  region.volume = integrals.Volume();
  region.over_c = AsPath(boundary->over_c);
  region.over_d = AsPath(boundary->over_d);
  return region;
}

}  // namespace annulus
