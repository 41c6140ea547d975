#include "render/screen_mesh.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "base/bands.h"

namespace annulus {
namespace {

constexpr std::size_t kVerticesPerTask = 8192;
/// Faces are clipped at this multiple of the picture, which keeps the integers below 2^56.
constexpr double kGuard = 4.0;

std::array<ClipPlane, 5> ClipPlanesOf(const PixelSamples& grid, double widening) {
  const double up = widening * grid.half_height;
  const double right = up * grid.width / grid.height;
  const bool perspective = grid.projection == Projection::kPerspective;
  const auto side = [perspective](double x, double y, double extent) {
    return perspective ? ClipPlane{{x, y, extent}, 0.0} : ClipPlane{{x, y, 0.0}, extent};
  };
  return {ClipPlane{Eigen::Vector3d::UnitZ(), -grid.near_mm}, side(1.0, 0.0, right), side(-1.0, 0.0, right),
          side(0.0, 1.0, up), side(0.0, -1.0, up)};
}

bool IsCut(const ClipPlane& plane, const ClipPolygon& polygon) {
  return std::any_of(polygon.corner.begin(), polygon.corner.begin() + polygon.count,
                     [&plane](const Eigen::Vector3d& p) { return plane.Distance(p) < 0.0; });
}

bool IsOutside(const std::array<ClipPlane, 5>& planes, const ClipPolygon& triangle) {
  return std::any_of(planes.begin(), planes.end(), [&triangle](const ClipPlane& plane) {
    return plane.Distance(triangle.corner[0]) < 0.0 && plane.Distance(triangle.corner[1]) < 0.0 &&
           plane.Distance(triangle.corner[2]) < 0.0;
  });
}

std::int64_t Snap(double samples) {
  return static_cast<std::int64_t>(std::floor(samples * static_cast<double>(kSubsample) + 0.5));
}

// Centres lie at kSubsample * column + kSubsample / 2; the shift rounds down for negative positions too.
int FirstCentreFrom(std::int64_t position) {
  return static_cast<int>((position - kSubsample / 2 + kSubsample - 1) >> 8);
}
int LastCentreTo(std::int64_t position) { return static_cast<int>((position - kSubsample / 2) >> 8); }

}  // namespace

ScreenMesh::ScreenMesh(const CameraMesh& mesh, const PixelSamples& grid, const std::stop_token& stop)
    : mesh_(mesh), grid_(grid), view_planes_(ClipPlanesOf(grid, 1.0)), guard_planes_(ClipPlanesOf(grid, kGuard)) {
  Project(stop);
  chunks_.resize((mesh.faces.size() + kChunkFaces - 1) / kChunkFaces);
  ForEachBand(static_cast<int>(chunks_.size()), grid.threads, stop, [&](int index) {
    chunks_[static_cast<std::size_t>(index)] = SortChunk(static_cast<std::size_t>(index));
  });
}

void ScreenMesh::Project(const std::stop_token& stop) {
  vertices_.resize(mesh_.vertices.size());
  const std::size_t tasks = (vertices_.size() + kVerticesPerTask - 1) / kVerticesPerTask;
  ForEachBand(static_cast<int>(tasks), grid_.threads, stop, [&](int task) {
    const std::size_t from = static_cast<std::size_t>(task) * kVerticesPerTask;
    const std::size_t to = std::min(from + kVerticesPerTask, vertices_.size());
    for (std::size_t k = from; k < to; ++k) vertices_[k] = ToGrid(mesh_.vertices[k]);
  });
}

ScreenMesh::Vertex ScreenMesh::ToGrid(const Eigen::Vector3d& p) const {
  if (!(p.z() >= grid_.near_mm)) return {};
  const double scale = (grid_.projection == Projection::kPerspective ? 1.0 / p.z() : 1.0) / grid_.Pitch();
  const double right = p.x() * scale;
  const double up = p.y() * scale;
  if (!(std::abs(right) <= 0.5 * kGuard * grid_.width && std::abs(up) <= 0.5 * kGuard * grid_.height)) return {};
  return {static_cast<std::int32_t>(Snap(0.5 * grid_.width + right)),
          static_cast<std::int32_t>(Snap(0.5 * grid_.height - up))};
}

SampleWindow ScreenMesh::Window() const {
  if (mesh_.vertices.empty()) return {};
  std::int32_t left = INT32_MAX;
  std::int32_t right = INT32_MIN;
  std::int32_t top = INT32_MAX;
  std::int32_t bottom = INT32_MIN;
  for (const Vertex& vertex : vertices_) {
    if (vertex.x == kOffGrid) return {0, 0, grid_.width, grid_.height};
    left = std::min(left, vertex.x);
    right = std::max(right, vertex.x);
    top = std::min(top, vertex.y);
    bottom = std::max(bottom, vertex.y);
  }
  const int step = grid_.supersampling;
  const int column = std::max(FirstCentreFrom(left), 0) / step * step;
  const int row = std::max(FirstCentreFrom(top), 0) / step * step;
  const int column_end = std::min((LastCentreTo(right) / step + 1) * step, grid_.width);
  const int row_end = std::min((LastCentreTo(bottom) / step + 1) * step, grid_.height);
  if (LastCentreTo(right) < 0 || LastCentreTo(bottom) < 0 || column >= column_end || row >= row_end) return {};
  return {column, row, column_end - column, row_end - row};
}

ScreenMesh::Chunk ScreenMesh::SortChunk(std::size_t index) const {
  Chunk chunk;
  std::vector<Span> spans;
  const std::size_t from = index * kChunkFaces;
  const std::size_t to = std::min(from + kChunkFaces, mesh_.faces.size());
  spans.reserve(to - from);
  for (std::size_t face = from; face < to; ++face) {
    const Vertex& a = vertices_[mesh_.faces[face][0]];
    const Vertex& b = vertices_[mesh_.faces[face][1]];
    const Vertex& c = vertices_[mesh_.faces[face][2]];
    if (a.x == kOffGrid || b.x == kOffGrid || c.x == kOffGrid) {
      AddClipped(static_cast<std::uint32_t>(face), chunk, spans);
      continue;
    }
    const int column_from = std::max(FirstCentreFrom(std::min({a.x, b.x, c.x})), 0);
    const int column_to = std::min(LastCentreTo(std::max({a.x, b.x, c.x})), grid_.width - 1);
    const int row_from = std::max(FirstCentreFrom(std::min({a.y, b.y, c.y})), 0);
    const int row_to = std::min(LastCentreTo(std::max({a.y, b.y, c.y})), grid_.height - 1);
    if (column_from > column_to || row_from > row_to) continue;
    spans.push_back({static_cast<std::uint32_t>(face - from), row_from / kBandRows, row_to / kBandRows});
  }
  chunk.band_begin.assign(static_cast<std::size_t>(band_count()) + 1, 0);
  for (const Span& span : spans) {
    for (int band = span.band_from; band <= span.band_to; ++band)
      ++chunk.band_begin[static_cast<std::size_t>(band) + 1];
  }
  for (std::size_t band = 1; band < chunk.band_begin.size(); ++band)
    chunk.band_begin[band] += chunk.band_begin[band - 1];
  chunk.entries.resize(chunk.band_begin.back());
  std::vector<std::uint32_t> next(chunk.band_begin.begin(), chunk.band_begin.end() - 1);
  for (const Span& span : spans) {
    for (int band = span.band_from; band <= span.band_to; ++band) {
      chunk.entries[next[static_cast<std::size_t>(band)]++] = span.entry;
    }
  }
  return chunk;
}

void ScreenMesh::AddClipped(std::uint32_t face, Chunk& chunk, std::vector<Span>& spans) const {
  ClipPolygon polygon;
  for (const std::uint32_t vertex : mesh_.faces[face]) polygon.Add(mesh_.vertices[vertex]);
  if (IsOutside(view_planes_, polygon)) return;
  const Eigen::Vector3d normal = (polygon.corner[1] - polygon.corner[0]).cross(polygon.corner[2] - polygon.corner[0]);
  ScreenTriangle base;
  base.face = face;
  if (!SetDepthPlane(normal, normal.dot(polygon.corner[0]), base)) return;
  for (const ClipPlane& plane : guard_planes_) {
    if (IsCut(plane, polygon)) polygon = ClipAt(plane, polygon);
  }
  for (int k = 2; k < polygon.count; ++k) {
    const std::array<Eigen::Vector3d, 3> corners = {polygon.corner[0], polygon.corner[static_cast<std::size_t>(k - 1)],
                                                    polygon.corner[static_cast<std::size_t>(k)]};
    if (!AddPiece(base, corners, chunk.clipped)) continue;
    const ScreenTriangle& piece = chunk.clipped.back();
    spans.push_back({kClipped | static_cast<std::uint32_t>(chunk.clipped.size() - 1), piece.row_from / kBandRows,
                     piece.row_to / kBandRows});
  }
}

bool ScreenMesh::AddPiece(ScreenTriangle triangle, const std::array<Eigen::Vector3d, 3>& corners,
                          std::vector<ScreenTriangle>& pieces) const {
  for (std::size_t k = 0; k < 3; ++k) {
    // As ToGrid computes it: a vertex that needed no clipping is found again.
    const double scale = (grid_.projection == Projection::kPerspective ? 1.0 / corners[k].z() : 1.0) / grid_.Pitch();
    triangle.x[k] = Snap(0.5 * grid_.width + corners[k].x() * scale);
    triangle.y[k] = Snap(0.5 * grid_.height - corners[k].y() * scale);
  }
  const auto [nearest, farthest] = std::minmax({corners[0].z(), corners[1].z(), corners[2].z()});
  triangle.nearest = nearest;
  triangle.farthest = farthest;
  if (!SetBounds(triangle)) return false;
  pieces.push_back(triangle);
  return true;
}

bool ScreenMesh::SetUp(ScreenTriangle& triangle) const {
  const auto& face = mesh_.faces[triangle.face];
  for (std::size_t k = 0; k < 3; ++k) {
    triangle.x[k] = vertices_[face[k]].x;
    triangle.y[k] = vertices_[face[k]].y;
  }
  if (!SetBounds(triangle)) return false;
  const Eigen::Vector3d& a = mesh_.vertices[face[0]];
  const Eigen::Vector3d& b = mesh_.vertices[face[1]];
  const Eigen::Vector3d& c = mesh_.vertices[face[2]];
  const auto [nearest, farthest] = std::minmax({a.z(), b.z(), c.z()});
  triangle.nearest = nearest;
  triangle.farthest = farthest;
  const Eigen::Vector3d normal = (b - a).cross(c - a);
  return SetDepthPlane(normal, normal.dot(a), triangle);
}

bool ScreenMesh::SetBounds(ScreenTriangle& triangle) const {
  const std::int64_t area = (triangle.x[1] - triangle.x[0]) * (triangle.y[2] - triangle.y[0]) -
                            (triangle.y[1] - triangle.y[0]) * (triangle.x[2] - triangle.x[0]);
  if (area == 0) return false;
  if (area < 0) {
    std::swap(triangle.x[1], triangle.x[2]);
    std::swap(triangle.y[1], triangle.y[2]);
  }
  triangle.column_from = std::max(FirstCentreFrom(std::min({triangle.x[0], triangle.x[1], triangle.x[2]})), 0);
  triangle.column_to = std::min(LastCentreTo(std::max({triangle.x[0], triangle.x[1], triangle.x[2]})), grid_.width - 1);
  triangle.row_from = std::max(FirstCentreFrom(std::min({triangle.y[0], triangle.y[1], triangle.y[2]})), 0);
  triangle.row_to = std::min(LastCentreTo(std::max({triangle.y[0], triangle.y[1], triangle.y[2]})), grid_.height - 1);
  return triangle.column_from <= triangle.column_to && triangle.row_from <= triangle.row_to;
}

/// The plane normal . p = offset as a linear function of column and row. Perspective: p = depth * (u, v, 1), hence
/// 1 / depth = normal . (u, v, 1) / offset. False if the plane is seen edge on.
bool ScreenMesh::SetDepthPlane(const Eigen::Vector3d& normal, double offset, ScreenTriangle& triangle) const {
  const bool perspective = grid_.projection == Projection::kPerspective;
  const double divisor = perspective ? offset : -normal.z();
  if (divisor == 0.0 || !std::isfinite(divisor)) return false;
  const double per_divisor = 1.0 / divisor;
  const double per_u = normal.x() * per_divisor;
  const double per_v = normal.y() * per_divisor;
  const double constant = (perspective ? normal.z() : -offset) * per_divisor;
  const double pitch = grid_.Pitch();
  triangle.per_column = per_u * pitch;
  triangle.per_row = -per_v * pitch;
  triangle.at_origin =
      constant + triangle.per_column * (0.5 - 0.5 * grid_.width) + triangle.per_row * (0.5 - 0.5 * grid_.height);
  return std::isfinite(triangle.at_origin) && std::isfinite(triangle.per_column) && std::isfinite(triangle.per_row);
}

}  // namespace annulus
