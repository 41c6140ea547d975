#include "modeling/mesh/mesh_section.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <utility>

namespace annulus {
namespace {

using EdgeKey = std::pair<std::uint32_t, std::uint32_t>;  // smaller vertex first: the same from both triangles

// The cut of one triangle, walked so that material is on the left: it enters through the edge that leads downwards.
struct Segment {
  EdgeKey start, end;
};

EdgeKey KeyOf(std::uint32_t a, std::uint32_t b) { return {std::min(a, b), std::max(a, b)}; }

Eigen::Vector2d CrossingPoint(const TriangleMesh& mesh, const EdgeKey& edge, double z) {
  const Eigen::Vector3d& a = mesh.vertices[edge.first];
  const Eigen::Vector3d& b = mesh.vertices[edge.second];
  const double share = (z - a.z()) / (b.z() - a.z());
  return a.head<2>() + share * (b.head<2>() - a.head<2>());
}

std::vector<Segment> CutTriangles(const TriangleMesh& mesh, double z) {
  std::vector<Segment> segments;
  for (const auto& face : mesh.faces) {
    Segment segment;
    int crossings = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t from = face[k];
      const std::uint32_t to = face[(k + 1) % 3];
      const bool from_above = mesh.vertices[from].z() >= z;
      const bool to_above = mesh.vertices[to].z() >= z;
      if (from_above == to_above) continue;
      (from_above ? segment.start : segment.end) = KeyOf(from, to);
      ++crossings;
    }
    if (crossings == 2) segments.push_back(segment);
  }
  return segments;
}

// Chains segments end to start. Each is used once.
class Chainer {
 public:
  explicit Chainer(std::vector<Segment> segments) : segments_(std::move(segments)), used_(segments_.size(), 0) {
    std::stable_sort(segments_.begin(), segments_.end(),
                     [](const Segment& a, const Segment& b) { return a.start < b.start; });
    for (const Segment& segment : segments_) ends_.push_back(segment.end);
    std::sort(ends_.begin(), ends_.end());
  }

  // All chains as lists of crossed edges; open ones first have their last edge too.
  struct Chain {
    std::vector<EdgeKey> edges;
    bool closed = false;
  };
  std::vector<Chain> Chains() {
    std::vector<Chain> chains;
    // An open chain begins where nothing ends.
    for (std::size_t i = 0; i < segments_.size(); ++i) {
      if (!std::binary_search(ends_.begin(), ends_.end(), segments_[i].start)) chains.push_back(Follow(i));
    }
    for (std::size_t i = 0; i < segments_.size(); ++i) {
      if (used_[i] == 0) chains.push_back(Follow(i));
    }
    return chains;
  }

 private:
  Chain Follow(std::size_t index) {
    Chain chain;
    const EdgeKey first = segments_[index].start;
    while (true) {
      used_[index] = 1;
      chain.edges.push_back(segments_[index].start);
      const EdgeKey end = segments_[index].end;
      if (end == first) {
        chain.closed = true;
        return chain;
      }
      auto next = std::lower_bound(segments_.begin(), segments_.end(), end,
                                   [](const Segment& segment, const EdgeKey& key) { return segment.start < key; });
      while (next != segments_.end() && next->start == end &&
             used_[static_cast<std::size_t>(next - segments_.begin())] != 0) {
        ++next;
      }
      if (next == segments_.end() || next->start != end) {
        chain.edges.push_back(end);
        return chain;
      }
      index = static_cast<std::size_t>(next - segments_.begin());
    }
  }

  std::vector<Segment> segments_;
  std::vector<char> used_;
  std::vector<EdgeKey> ends_;
};

SectionLoop MeasureChain(const TriangleMesh& mesh, const Chainer::Chain& chain, double z) {
  SectionLoop loop;
  loop.closed = chain.closed;
  for (const EdgeKey& edge : chain.edges) {
    const Eigen::Vector2d point = CrossingPoint(mesh, edge, z);
    if (loop.points.empty() || loop.points.back() != point) loop.points.push_back(point);
  }
  if (loop.closed && loop.points.size() > 1 && loop.points.front() == loop.points.back()) loop.points.pop_back();
  const std::size_t count = loop.points.size();
  for (std::size_t i = 0; i + 1 < count || (loop.closed && i < count); ++i) {
    const Eigen::Vector2d& a = loop.points[i];
    const Eigen::Vector2d& b = loop.points[(i + 1) % count];
    loop.perimeter_mm += (b - a).norm();
    // About the first point, so that little cancels.
    const Eigen::Vector2d u = a - loop.points.front();
    const Eigen::Vector2d v = b - loop.points.front();
    if (loop.closed) loop.area_mm2 += 0.5 * (u.x() * v.y() - u.y() * v.x());
  }
  return loop;
}

// A convex polygon of at most five corners: a triangle cut by two planes.
struct Polygon {
  std::array<Eigen::Vector3d, 5> corners;
  std::size_t count = 0;
  void Add(const Eigen::Vector3d& corner) { corners[count++] = corner; }
};

// What of `polygon` has sign · z <= sign · limit.
Polygon ClipHeight(const Polygon& polygon, double limit, double sign) {
  Polygon kept;
  for (std::size_t i = 0; i < polygon.count; ++i) {
    const Eigen::Vector3d& a = polygon.corners[i];
    const Eigen::Vector3d& b = polygon.corners[(i + 1) % polygon.count];
    const double beyond_a = sign * (a.z() - limit);
    const double beyond_b = sign * (b.z() - limit);
    if (beyond_a <= 0.0) kept.Add(a);
    if ((beyond_a < 0.0 && beyond_b > 0.0) || (beyond_a > 0.0 && beyond_b < 0.0)) {
      kept.Add(a + (b - a) * (beyond_a / (beyond_a - beyond_b)));
    }
  }
  return kept;
}

}  // namespace

std::vector<SectionLoop> SliceMesh(const TriangleMesh& mesh, double z) {
  std::vector<SectionLoop> loops;
  for (const Chainer::Chain& chain : Chainer(CutTriangles(mesh, z)).Chains()) {
    SectionLoop loop = MeasureChain(mesh, chain, z);
    if (loop.points.size() >= (loop.closed ? 3U : 2U)) loops.push_back(std::move(loop));
  }
  std::stable_sort(loops.begin(), loops.end(), [](const SectionLoop& a, const SectionLoop& b) {
    return std::abs(a.area_mm2) > std::abs(b.area_mm2);
  });
  return loops;
}

double SlabVolume(const TriangleMesh& mesh, double z0, double z1) {
  if (mesh.vertices.empty()) return 0.0;
  const double x_origin = mesh.vertices.front().x();  // near the mesh, so that little cancels
  double volume = 0.0;
  for (const auto& face : mesh.faces) {
    Polygon polygon;
    for (const std::uint32_t vertex : face) polygon.Add(mesh.vertices[vertex]);
    polygon = ClipHeight(ClipHeight(polygon, z1, 1.0), z0, -1.0);
    for (std::size_t i = 1; i + 1 < polygon.count; ++i) {
      const Eigen::Vector3d& a = polygon.corners[0];
      const Eigen::Vector3d& b = polygon.corners[i];
      const Eigen::Vector3d& c = polygon.corners[i + 1];
      const double area_x = 0.5 * ((b - a).cross(c - a)).x();  // n_x dA
      volume += area_x * ((a.x() + b.x() + c.x()) / 3.0 - x_origin);
    }
  }
  return volume;
}

}  // namespace annulus
