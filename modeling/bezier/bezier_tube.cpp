#include "modeling/bezier/bezier_tube.h"

#include <cmath>
#include <cstdint>
#include <vector>

#include "base/ensure.h"

namespace annulus {
namespace {

/// Fig. 5: each row of a patch is a U from one seam over the depth to the other seam.
BezierPatch MakeHalf(const BezierTube::Sections& sections, double side) {
  BezierPatch::ControlNet net;
  for (std::size_t i = 0; i < 4; ++i) {
    const TubeSection& section = sections[i];
    const Eigen::Vector3d width = side * section.half_width;
    const Eigen::Vector3d depth = side * section.half_depth;
    const Eigen::Vector3d start = section.centre - width;
    const Eigen::Vector3d end = section.centre + width;
    net[i] = {start, start + depth, end + depth, end};
  }
  return BezierPatch(net);
}

/// One closed ring of vertices around a tube at `u`; both seams once.
void AppendRing(const BezierTube& tube, double u, std::size_t around, TriangleMesh& mesh) {
  const std::size_t count = 2 * around;
  for (std::size_t k = 0; k < count; ++k) {
    mesh.vertices.push_back(tube.Point(u, static_cast<double>(k) / static_cast<double>(count)));
  }
}

/// Triangles between ring `from` and ring `to` (numbers of rings of `count` vertices).
void AppendBand(std::size_t from, std::size_t to, std::size_t count, TriangleMesh& mesh) {
  for (std::size_t k = 0; k < count; ++k) {
    const std::size_t next = (k + 1) % count;
    const auto a = static_cast<std::uint32_t>(from * count + k);
    const auto b = static_cast<std::uint32_t>(to * count + k);
    const auto c = static_cast<std::uint32_t>(to * count + next);
    const auto d = static_cast<std::uint32_t>(from * count + next);
    mesh.faces.push_back({a, b, c});
    mesh.faces.push_back({a, c, d});
  }
}

enum class CapSide { kStart, kEnd };

/// A fan that closes ring `ring` around `centre`.
void AppendCap(std::size_t ring, std::size_t count, const Eigen::Vector3d& centre, CapSide side, TriangleMesh& mesh) {
  const auto middle = static_cast<std::uint32_t>(mesh.vertices.size());
  mesh.vertices.push_back(centre);
  for (std::size_t k = 0; k < count; ++k) {
    const auto a = static_cast<std::uint32_t>(ring * count + k);
    const auto b = static_cast<std::uint32_t>(ring * count + (k + 1) % count);
    if (side == CapSide::kStart) {
      mesh.faces.push_back({middle, a, b});
    } else {
      mesh.faces.push_back({middle, b, a});
    }
  }
}

}  // namespace

BezierTube::BezierTube(const Sections& sections)
    : sections_(sections), a_(MakeHalf(sections, 1.0)), b_(MakeHalf(sections, -1.0)) {}

Eigen::Vector3d BezierTube::CentreLine(double u) const {
  return CubicBezierPoint({sections_[0].centre, sections_[1].centre, sections_[2].centre, sections_[3].centre}, u);
}

Eigen::Vector3d BezierTube::Point(double u, double around) const {
  return around < 0.5 ? a_.Point(u, 2.0 * around) : b_.Point(u, 2.0 * around - 1.0);
}

BezierTube BezierTube::MirroredX() const {
  const auto mirror = [](const Eigen::Vector3d& p) { return Eigen::Vector3d(-p.x(), p.y(), p.z()); };
  Sections mirrored;
  for (std::size_t i = 0; i < 4; ++i) {
    mirrored[i] = {mirror(sections_[i].centre), mirror(sections_[i].half_width), -mirror(sections_[i].half_depth)};
  }
  return BezierTube(mirrored);
}

TriangleMesh TessellateChain(std::span<const BezierTube> chain, TubeEnds ends, const TubeTessellation& tessellation) {
  ENSURE(!chain.empty() && tessellation.along >= 1 && tessellation.around >= 2, "a chain has tubes and steps");
  const std::size_t count = 2 * tessellation.around;
  const auto along = static_cast<double>(tessellation.along);
  TriangleMesh mesh;
  std::size_t rings = 0;
  for (const BezierTube& tube : chain) {
    for (std::size_t step = 0; step < tessellation.along; ++step, ++rings) {
      AppendRing(tube, static_cast<double>(step) / along, tessellation.around, mesh);
    }
  }
  if (ends == TubeEnds::kCapped) {
    AppendRing(chain.back(), 1.0, tessellation.around, mesh);
    ++rings;
  }
  for (std::size_t ring = 0; ring + 1 < rings; ++ring) AppendBand(ring, ring + 1, count, mesh);
  if (ends == TubeEnds::kLoop) {
    AppendBand(rings - 1, 0, count, mesh);
  } else {
    AppendCap(0, count, chain.front().CentreLine(0.0), CapSide::kStart, mesh);
    AppendCap(rings - 1, count, chain.back().CentreLine(1.0), CapSide::kEnd, mesh);
  }
  return mesh;
}

}  // namespace annulus
