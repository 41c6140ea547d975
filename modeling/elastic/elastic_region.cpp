#include "modeling/elastic/elastic_region.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <string>

#include "modeling/measure/gauss.h"

namespace annulus {
namespace {

using Eigen::Vector3d;

constexpr const char* kAttempted = "make a soft layer of a measured surface";
constexpr std::size_t kMostNodes = 200'000;
constexpr std::size_t kMostSweeps = 400;

Status CheckRequest(const SurfaceSegment& segment, const RegionRequest& request) {
  const auto refuse = [](std::string seen, std::string advice) { return Fail(kAttempted, std::move(seen), advice); };
  if (!(request.theta_to - request.theta_from > 0.0) || !std::isfinite(request.theta_from + request.theta_to)) {
    return refuse("its angles do not rise", "give theta from a smaller to a larger angle");
  }
  if (!(request.z_min >= segment.surface.z_min() && request.z_max <= segment.surface.z_max() &&
        request.z_min < request.z_max)) {
    return refuse("its heights are " + std::to_string(request.z_min) + " to " + std::to_string(request.z_max) +
                      " mm, the segment's " + std::to_string(segment.surface.z_min()) + " to " +
                      std::to_string(segment.surface.z_max()),
                  "give heights within the segment's");
  }
  if (!(request.spacing >= 1.0 && request.spacing <= 100.0)) return refuse("spacing is not 1 to 100 mm", "give one");
  if (request.layers < 2 || request.layers > 9) return refuse("layers is not 2 to 9", "give 3");
  if (!(request.thickness > 0.0 && request.thickness <= 1000.0)) {
    return refuse("thickness is not 0 to 1000 mm", "give that of the soft tissue, such as 20");
  }
  return {};
}

/// Rows and columns at about equal distances.
GridShape ShapeOf(const SurfaceSegment& segment, const RegionRequest& request) {
  const bool closed = request.theta_to - request.theta_from >= kTwoPi - 1e-9;
  const double turn = closed ? kTwoPi : request.theta_to - request.theta_from;
  double radius = 0.0;
  constexpr int kPlaces = 12;
  for (int k = 0; k < kPlaces * kPlaces; ++k) {
    const double theta = request.theta_from + turn * (k % kPlaces + 0.5) / kPlaces;
    const double z = request.z_min + (request.z_max - request.z_min) * (k / kPlaces + 0.5) / kPlaces;
    radius += segment.surface.Radius(theta, z) / (kPlaces * kPlaces);
  }
  const auto cells = [&](double length) {
    return static_cast<std::size_t>(std::clamp(std::round(length / request.spacing), 3.0, 1e5));
  };
  GridShape shape;
  shape.closure = closed ? GridClosure::kClosed : GridClosure::kOpen;
  shape.columns = cells(turn * radius) + (closed ? 0 : 1);
  shape.rows = cells(request.z_max - request.z_min) + 1;
  shape.layers = request.layers;
  return shape;
}

/// Triple product at each corner of an element: all positive where it is right side out.
bool RightSideOut(const SolidGrid& grid, std::size_t pile, std::size_t level) {
  const std::array<std::size_t, 8> nodes = grid.NodesOf(pile, level);
  for (std::size_t a = 0; a < 8; ++a) {
    const Vector3d& at = grid.nodes[nodes[a]];
    std::array<Vector3d, 3> edge;
    double sign = 1.0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      edge[axis] = grid.nodes[nodes[a ^ (std::size_t{1} << axis)]] - at;
      if ((a >> axis) % 2 == 1) sign = -sign;
    }
    const double volume = sign * edge[0].cross(edge[1]).dot(edge[2]);
    if (!(volume > 1e-3 * edge[0].norm() * edge[1].norm() * edge[2].norm())) return false;
  }
  return true;
}

bool RightSideOut(const SolidGrid& grid) {
  for (std::size_t pile = 0; pile < grid.shape.piles(); ++pile) {
    for (std::size_t level = 0; level + 1 < grid.shape.layers; ++level) {
      if (!RightSideOut(grid, pile, level)) return false;
    }
  }
  return true;
}

/// Every direction becomes the mean of its own and its neighbours'.
std::vector<Vector3d> Smoothed(const std::vector<Vector3d>& directions, const GridShape& shape) {
  std::vector<Vector3d> result(directions.size());
  const bool closed = shape.closure == GridClosure::kClosed;
  for (std::size_t j = 0; j < shape.rows; ++j) {
    for (std::size_t i = 0; i < shape.columns; ++i) {
      const std::size_t right = closed ? (i + 1) % shape.columns : std::min(i + 1, shape.columns - 1);
      const std::size_t left = closed ? (i + shape.columns - 1) % shape.columns : (i == 0 ? 0 : i - 1);
      const std::size_t above = std::min(j + 1, shape.rows - 1);
      const std::size_t below = j == 0 ? 0 : j - 1;
      const Vector3d sum = directions[j * shape.columns + i] + directions[j * shape.columns + left] +
                           directions[j * shape.columns + right] + directions[above * shape.columns + i] +
                           directions[below * shape.columns + i];
      result[j * shape.columns + i] = sum.normalized();
    }
  }
  return result;
}

/// Nodes below the skin along `inward`-turned directions.
void SetDepths(const std::vector<Vector3d>& outward, double thickness, SolidGrid& grid) {
  const std::size_t layers = grid.shape.layers;
  for (std::size_t stack = 0; stack < grid.shape.stacks(); ++stack) {
    const Vector3d skin = grid.nodes[stack * layers + layers - 1];
    for (std::size_t k = 0; k + 1 < layers; ++k) {
      const double depth = thickness * static_cast<double>(layers - 1 - k) / static_cast<double>(layers - 1);
      grid.nodes[stack * layers + k] = skin - depth * outward[stack];
    }
  }
}

void SetAreas(ElasticRegion& region) {
  region.area.assign(region.grid.shape.stacks(), 0.0);
  for (std::size_t pile = 0; pile < region.grid.shape.piles(); ++pile) {
    const std::array<std::size_t, 4> stacks = region.grid.shape.StacksOf(pile);
    const auto at = [&](std::size_t k) { return region.grid.nodes[region.SkinNode(stacks[k])]; };
    const double area = 0.5 * (at(3) - at(0)).cross(at(2) - at(1)).norm();
    for (const std::size_t stack : stacks) region.area[stack] += 0.25 * area;
  }
}

void Hold(ElasticRegion& region) {
  const GridShape& shape = region.grid.shape;
  region.held.assign(3 * shape.nodes(), 0);
  for (std::size_t stack = 0; stack < shape.stacks(); ++stack) {
    for (std::size_t k = 0; k < shape.layers; ++k) {
      if (k > 0 && !region.OnRim(stack)) continue;
      for (std::size_t c = 0; c < 3; ++c) region.held[3 * (stack * shape.layers + k) + c] = 1;
    }
  }
}

}  // namespace

bool ElasticRegion::OnRim(std::size_t stack) const {
  const std::size_t i = stack % grid.shape.columns;
  const std::size_t j = stack / grid.shape.columns;
  if (j == 0 || j + 1 == grid.shape.rows) return true;
  return grid.shape.closure == GridClosure::kOpen && (i == 0 || i + 1 == grid.shape.columns);
}

Vector3d SegmentNormal(const SurfaceSegment& segment, double theta, double z) {
  const RadiusJet r = segment.surface.Jet(theta, z);
  const Vector3d out(std::cos(theta), std::sin(theta), 0.0);
  const Vector3d around(-out.y(), out.x(), 0.0);
  const Eigen::Vector2d lean = segment.axis.slope + 2.0 * (z - segment.axis.z_middle) * segment.axis.bend;
  const Vector3d by_theta = r.r_theta * out + r.r * around;
  const Vector3d by_z = Vector3d(lean.x(), lean.y(), 1.0) + r.r_z * out;
  return by_theta.cross(by_z).normalized();
}

Result<ElasticRegion> MakeElasticRegion(const SurfaceSegment& segment, const RegionRequest& request) {
  RETURN_IF_ERROR(CheckRequest(segment, request));
  ElasticRegion region;
  region.request = request;
  SolidGrid& grid = region.grid;
  grid.shape = ShapeOf(segment, request);
  const GridShape& shape = grid.shape;
  if (shape.nodes() > kMostNodes) {
    return Fail(kAttempted, "it takes " + std::to_string(shape.nodes()) + " nodes", "give a larger spacing_mm");
  }
  const double turn = shape.closure == GridClosure::kClosed ? kTwoPi : request.theta_to - request.theta_from;
  for (std::size_t i = 0; i < shape.columns; ++i) {
    region.theta.push_back(request.theta_from +
                           turn * static_cast<double>(i) / static_cast<double>(shape.cells_around()));
  }
  for (std::size_t j = 0; j < shape.rows; ++j) {
    region.z.push_back(request.z_min +
                       (request.z_max - request.z_min) * static_cast<double>(j) / static_cast<double>(shape.rows - 1));
  }
  grid.nodes.resize(shape.nodes());
  for (std::size_t stack = 0; stack < shape.stacks(); ++stack) {
    const double theta = region.theta[stack % shape.columns];
    const double z = region.z[stack / shape.columns];
    const double radius = segment.surface.Radius(theta, z);
    if (!(radius > request.thickness)) {
      return Fail(kAttempted,
                  "at z " + std::to_string(z) + " mm the radius is " + std::to_string(radius) +
                      " mm, no more than the thickness",
                  "give a smaller thickness_mm or another region");
    }
    grid.nodes[region.SkinNode(stack)] = segment.Point(theta, z);
    region.normal.push_back(SegmentNormal(segment, theta, z));
  }
  std::vector<Vector3d> outward = region.normal;
  for (SetDepths(outward, request.thickness, grid); !RightSideOut(grid); SetDepths(outward, request.thickness, grid)) {
    if (region.sweeps == kMostSweeps) {
      return Fail(kAttempted, "a layer of " + std::to_string(request.thickness) + " mm would cross itself",
                  "give a smaller thickness_mm or a smaller region");
    }
    outward = Smoothed(outward, shape);
    ++region.sweeps;
  }
  SetAreas(region);
  Hold(region);
  return region;
}

double SegmentVolume(const SurfaceSegment& segment) {
  const std::size_t columns = segment.surface.theta_basis().count();
  std::vector<double> theta;
  for (std::size_t i = 0; i <= columns; ++i) {
    theta.push_back(kTwoPi * static_cast<double>(i) / static_cast<double>(columns));
  }
  const std::vector<QuadratureNode> around = PiecewiseGauss(theta);
  double volume = 0.0;
  for (const QuadratureNode& z : PiecewiseGauss(segment.surface.z_basis().breakpoints())) {
    double area = 0.0;  // a sum of sums: less rounding
    for (const QuadratureNode& t : around) {
      const double radius = segment.surface.Radius(t.x, z.x);
      area += 0.5 * radius * radius * t.weight;
    }
    volume += area * z.weight;
  }
  return volume;
}

}  // namespace annulus
