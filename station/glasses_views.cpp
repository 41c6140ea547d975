#include "station/glasses_views.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <utility>

#include "modeling/mesh/bvh.h"

namespace annulus {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr ShellTessellation kDrawn{.along = 64, .around = 20, .straight = 2};
/// Faces whose normals turn by more than this are the sides of an edge: cos 35°.
constexpr double kSmooth = 0.82;
/// A line is looked for this far off its surface, mm, so that its own faces do not hide it.
constexpr double kLift = 0.02;
constexpr double kFarthest = 1000.0;

Vector3d TowardViewer(FrameView view) {
  switch (view) {
    case FrameView::kFront:
      return Vector3d::UnitY();
    case FrameView::kTop:
      return Vector3d::UnitZ();
    case FrameView::kSide:
      return Vector3d::UnitX();
  }
  return Vector3d::UnitY();
}

bool IsDrawn(const std::string& shell, FrameView view) { return view != FrameView::kSide || !shell.ends_with("_left"); }

/// The normals on both sides of an edge.
struct Sides {
  Vector3d first = Vector3d::Zero();
  Vector3d second = Vector3d::Zero();
  int count = 0;
};
using Edges = std::map<std::pair<std::uint32_t, std::uint32_t>, Sides>;

Edges EdgesOf(const TriangleMesh& mesh) {
  Edges edges;
  for (const auto& face : mesh.faces) {
    const Vector3d& a = mesh.vertices[face[0]];
    const Vector3d cross = (mesh.vertices[face[1]] - a).cross(mesh.vertices[face[2]] - a);
    if (!(cross.norm() > 1e-12)) continue;
    for (std::size_t k = 0; k < 3; ++k) {
      Sides& sides = edges[std::minmax(face[k], face[(k + 1) % 3])];
      (sides.count++ == 0 ? sides.first : sides.second) = cross.normalized();
    }
  }
  return edges;
}

}  // namespace

Vector2d InView(FrameView view, const Vector3d& p) {
  switch (view) {
    case FrameView::kFront:
      return {-p.x(), p.z()};
    case FrameView::kTop:
      return {-p.x(), -p.y()};
    case FrameView::kSide:
      return {p.y(), p.z()};
  }
  return {};
}

ViewLines VisibleLines(const std::vector<FrameBody>& bodies, FrameView view) {
  std::vector<TriangleMesh> meshes;
  TriangleMesh whole;
  for (const FrameBody& body : bodies) {
    for (const PatchShell& shell : body.shells) {
      if (!IsDrawn(shell.name, view)) continue;
      meshes.push_back(Tessellate(shell, kDrawn));
      Append(whole, meshes.back());
    }
  }
  const Bvh tree(whole);
  const Vector3d toward = TowardViewer(view);
  ViewLines lines;
  for (const Vector3d& p : whole.vertices) lines.box.extend(InView(view, p));
  for (const TriangleMesh& mesh : meshes) {
    for (const auto& [ends, sides] : EdgesOf(mesh)) {
      if (sides.count != 2) continue;
      const bool turns = (sides.first.dot(toward) > 0.0) != (sides.second.dot(toward) > 0.0);
      const bool sharp = sides.first.dot(sides.second) < kSmooth;
      if (!turns && !sharp) continue;
      const Vector3d& a = mesh.vertices[ends.first];
      const Vector3d& b = mesh.vertices[ends.second];
      const Vector3d off = (sides.first + sides.second).normalized();
      if (tree.Cast({0.5 * (a + b) + kLift * (off + toward), toward}, kFarthest)) continue;
      (turns ? lines.outlines : lines.creases).push_back({InView(view, a), InView(view, b)});
    }
  }
  return lines;
}

}  // namespace annulus
