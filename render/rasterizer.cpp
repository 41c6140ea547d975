#include "render/rasterizer.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "render/bands.h"

namespace annulus {
namespace {

constexpr int kBandRows = 32;
constexpr std::size_t kChunkFaces = 4096;
/// Vertices are rounded to 1/256 sample, so that the edge functions are exact integers and a shared edge is seen
/// identically from both sides.
constexpr std::int64_t kSubsample = 256;
/// Faces are clipped at this multiple of the picture, which keeps the integers below 2^56.
constexpr double kGuard = 4.0;

struct ScreenTriangle {
  std::array<std::int64_t, 3> x{};  // 1/256 sample, to the right
  std::array<std::int64_t, 3> y{};  // 1/256 sample, downwards
  // Perspective: 1 / depth, orthographic: depth, at (column, row) centres = at_origin + per_column * x + per_row * y.
  double at_origin = 0.0;
  double per_column = 0.0;
  double per_row = 0.0;
  double nearest = 0.0;   // mm
  double farthest = 0.0;  // mm
  std::uint32_t face = 0;
  int column_from = 0;
  int column_to = -1;
  int row_from = 0;
  int row_to = -1;
};

/// The triangles of some faces, and which of them reach into each band of rows.
struct Chunk {
  std::vector<ScreenTriangle> triangles;
  std::vector<std::vector<std::uint32_t>> in_band;
};

/// A convex polygon of at most 3 + 5 corners.
struct Polygon {
  std::array<Eigen::Vector3d, 8> corner;
  int count = 0;

  void Add(const Eigen::Vector3d& p) { corner[static_cast<std::size_t>(count++)] = p; }
};

/// Half space normal . p + offset >= 0 of the camera frame.
struct ClipPlane {
  Eigen::Vector3d normal;
  double offset = 0.0;

  [[nodiscard]] double Distance(const Eigen::Vector3d& p) const { return normal.dot(p) + offset; }
};

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

/// Sutherland-Hodgman for one plane. The crossing is always taken from the inner end, so that the two faces of an edge
/// get the same point.
Polygon ClipAt(const ClipPlane& plane, const Polygon& polygon) {
  Polygon clipped;
  for (int k = 0; k < polygon.count; ++k) {
    const Eigen::Vector3d& p = polygon.corner[static_cast<std::size_t>(k)];
    const Eigen::Vector3d& q = polygon.corner[static_cast<std::size_t>((k + 1) % polygon.count)];
    const double at_p = plane.Distance(p);
    const double at_q = plane.Distance(q);
    if (at_p >= 0.0) clipped.Add(p);
    if (at_p >= 0.0 && at_q < 0.0) clipped.Add(p + at_p / (at_p - at_q) * (q - p));
    if (at_p < 0.0 && at_q >= 0.0) clipped.Add(q + at_q / (at_q - at_p) * (p - q));
  }
  return clipped;
}

class TriangleSetup {
 public:
  TriangleSetup(const CameraMesh& mesh, const PixelSamples& grid)
      : mesh_(mesh), grid_(grid), view_planes_(ClipPlanesOf(grid, 1.0)), guard_planes_(ClipPlanesOf(grid, kGuard)) {}

  /// Appends what is visible of `face`: nothing, one triangle, or the fan of its clipped polygon.
  void AddFace(std::uint32_t face, std::vector<ScreenTriangle>& triangles) const {
    Polygon polygon;
    for (const std::uint32_t vertex : mesh_.faces[face]) polygon.Add(mesh_.vertices[vertex]);
    if (IsOutside(polygon)) return;
    const Eigen::Vector3d normal = (polygon.corner[1] - polygon.corner[0]).cross(polygon.corner[2] - polygon.corner[0]);
    ScreenTriangle base;
    base.face = face;
    if (!SetDepthPlane(normal, normal.dot(polygon.corner[0]), base)) return;
    for (const ClipPlane& plane : guard_planes_) {
      if (IsCut(plane, polygon)) polygon = ClipAt(plane, polygon);
    }
    for (int k = 2; k < polygon.count; ++k) {
      AddTriangle(base,
                  {polygon.corner[0], polygon.corner[static_cast<std::size_t>(k - 1)],
                   polygon.corner[static_cast<std::size_t>(k)]},
                  triangles);
    }
  }

 private:
  static bool IsCut(const ClipPlane& plane, const Polygon& polygon) {
    for (int k = 0; k < polygon.count; ++k) {
      if (plane.Distance(polygon.corner[static_cast<std::size_t>(k)]) < 0.0) return true;
    }
    return false;
  }

  bool IsOutside(const Polygon& triangle) const {
    return std::any_of(view_planes_.begin(), view_planes_.end(), [&triangle](const ClipPlane& plane) {
      return plane.Distance(triangle.corner[0]) < 0.0 && plane.Distance(triangle.corner[1]) < 0.0 &&
             plane.Distance(triangle.corner[2]) < 0.0;
    });
  }

  /// The plane normal . p = offset as a linear function of column and row. Perspective: p = depth * (u, v, 1), hence
  /// 1 / depth = normal . (u, v, 1) / offset. False if the plane is seen edge on.
  bool SetDepthPlane(const Eigen::Vector3d& normal, double offset, ScreenTriangle& triangle) const {
    const bool perspective = grid_.projection == Projection::kPerspective;
    const double divisor = perspective ? offset : -normal.z();
    if (divisor == 0.0 || !std::isfinite(divisor)) return false;
    const double per_u = normal.x() / divisor;
    const double per_v = normal.y() / divisor;
    const double constant = perspective ? normal.z() / divisor : -offset / divisor;
    const double pitch = grid_.Pitch();
    triangle.per_column = per_u * pitch;
    triangle.per_row = -per_v * pitch;
    triangle.at_origin =
        constant + per_u * pitch * (0.5 - 0.5 * grid_.width) + per_v * pitch * (0.5 * grid_.height - 0.5);
    return std::isfinite(triangle.at_origin) && std::isfinite(triangle.per_column) && std::isfinite(triangle.per_row);
  }

  void AddTriangle(ScreenTriangle triangle, const std::array<Eigen::Vector3d, 3>& corners,
                   std::vector<ScreenTriangle>& triangles) const {
    for (std::size_t k = 0; k < 3; ++k) {
      const double scale = grid_.projection == Projection::kPerspective ? 1.0 / corners[k].z() : 1.0;
      triangle.x[k] = Snap(0.5 * grid_.width + corners[k].x() * scale / grid_.Pitch());
      triangle.y[k] = Snap(0.5 * grid_.height - corners[k].y() * scale / grid_.Pitch());
    }
    const std::int64_t area = (triangle.x[1] - triangle.x[0]) * (triangle.y[2] - triangle.y[0]) -
                              (triangle.y[1] - triangle.y[0]) * (triangle.x[2] - triangle.x[0]);
    if (area == 0) return;
    if (area < 0) {
      std::swap(triangle.x[1], triangle.x[2]);
      std::swap(triangle.y[1], triangle.y[2]);
    }
    const auto [left, right] = std::minmax({triangle.x[0], triangle.x[1], triangle.x[2]});
    const auto [top, bottom] = std::minmax({triangle.y[0], triangle.y[1], triangle.y[2]});
    triangle.column_from = std::max(FirstCentreFrom(left), 0);
    triangle.column_to = std::min(LastCentreTo(right), grid_.width - 1);
    triangle.row_from = std::max(FirstCentreFrom(top), 0);
    triangle.row_to = std::min(LastCentreTo(bottom), grid_.height - 1);
    if (triangle.column_from > triangle.column_to || triangle.row_from > triangle.row_to) return;
    const auto [nearest, farthest] = std::minmax({corners[0].z(), corners[1].z(), corners[2].z()});
    triangle.nearest = nearest;
    triangle.farthest = farthest;
    triangles.push_back(triangle);
  }

  static std::int64_t Snap(double samples) {
    return static_cast<std::int64_t>(std::floor(samples * static_cast<double>(kSubsample) + 0.5));
  }
  static int FirstCentreFrom(std::int64_t position) {
    // Centres lie at kSubsample * column + kSubsample / 2; the shift rounds down for negative positions too.
    return static_cast<int>((position - kSubsample / 2 + kSubsample - 1) >> 8);
  }
  static int LastCentreTo(std::int64_t position) { return static_cast<int>((position - kSubsample / 2) >> 8); }

  const CameraMesh& mesh_;  // outlives this object: both live in one call
  const PixelSamples& grid_;
  std::array<ClipPlane, 5> view_planes_;
  std::array<ClipPlane, 5> guard_planes_;
};

int BandCount(const PixelSamples& grid) { return (grid.height + kBandRows - 1) / kBandRows; }

std::vector<Chunk> SetUpChunks(const CameraMesh& mesh, const PixelSamples& grid, const std::stop_token& stop) {
  const TriangleSetup setup(mesh, grid);
  std::vector<Chunk> chunks((mesh.faces.size() + kChunkFaces - 1) / kChunkFaces);
  ForEachBand(static_cast<int>(chunks.size()), grid.threads, stop, [&](int index) {
    Chunk& chunk = chunks[static_cast<std::size_t>(index)];
    const std::size_t from = static_cast<std::size_t>(index) * kChunkFaces;
    const std::size_t to = std::min(from + kChunkFaces, mesh.faces.size());
    for (std::size_t face = from; face < to; ++face) setup.AddFace(static_cast<std::uint32_t>(face), chunk.triangles);
    chunk.in_band.resize(static_cast<std::size_t>(BandCount(grid)));
    for (std::uint32_t k = 0; k < chunk.triangles.size(); ++k) {
      const ScreenTriangle& triangle = chunk.triangles[k];
      for (int band = triangle.row_from / kBandRows; band <= triangle.row_to / kBandRows; ++band) {
        chunk.in_band[static_cast<std::size_t>(band)].push_back(k);
      }
    }
  });
  return chunks;
}

/// One edge function: positive inside, 0 on the edge. Of two faces at an edge exactly one owns the samples on it.
struct EdgeFunction {
  std::int64_t value = 0;  // at the first sample of the row
  std::int64_t per_column = 0;
  std::int64_t per_row = 0;

  EdgeFunction(const ScreenTriangle& triangle, std::size_t from, std::size_t to, int column, int row) {
    const std::int64_t dx = triangle.x[to] - triangle.x[from];
    const std::int64_t dy = triangle.y[to] - triangle.y[from];
    const std::int64_t x = column * kSubsample + kSubsample / 2 - triangle.x[from];
    const std::int64_t y = row * kSubsample + kSubsample / 2 - triangle.y[from];
    const bool owned = dy > 0 || (dy == 0 && dx < 0);
    value = dx * y - dy * x - (owned ? 0 : 1);
    per_column = -dy * kSubsample;
    per_row = dx * kSubsample;
  }
};

/// Calls visit(column, row, depth) for every sample centre that `triangle` covers in rows `row_from` … `row_to`.
template <class Visit>
void ForEachSample(const ScreenTriangle& triangle, bool is_perspective, std::array<int, 2> rows, Visit&& visit) {
  const int row_from = std::max(triangle.row_from, rows[0]);
  const int row_to = std::min(triangle.row_to, rows[1]);
  EdgeFunction edge0(triangle, 0, 1, triangle.column_from, row_from);
  EdgeFunction edge1(triangle, 1, 2, triangle.column_from, row_from);
  EdgeFunction edge2(triangle, 2, 0, triangle.column_from, row_from);
  for (int row = row_from; row <= row_to; ++row) {
    std::int64_t e0 = edge0.value;
    std::int64_t e1 = edge1.value;
    std::int64_t e2 = edge2.value;
    bool entered = false;
    for (int column = triangle.column_from; column <= triangle.column_to; ++column) {
      if ((e0 | e1 | e2) >= 0) {
        entered = true;
        const double at = triangle.at_origin + triangle.per_column * column + triangle.per_row * row;
        // A face seen nearly edge on has a steep plane; its depth never leaves that of its corners.
        const double depth = is_perspective ? 1.0 / at : at;
        const double kept = at > 0.0 ? std::clamp(depth, triangle.nearest, triangle.farthest) : triangle.farthest;
        visit(column, row, static_cast<float>(kept));
      } else if (entered) {
        break;  // convex: the row is over
      }
      e0 += edge0.per_column;
      e1 += edge1.per_column;
      e2 += edge2.per_column;
    }
    edge0.value += edge0.per_row;
    edge1.value += edge1.per_row;
    edge2.value += edge2.per_row;
  }
}

/// Draws all triangles of a band in the order of their faces, whatever thread does it.
template <class Visit>
void DrawBand(const std::vector<Chunk>& chunks, const PixelSamples& grid, int band, Visit&& visit) {
  const bool is_perspective = grid.projection == Projection::kPerspective;
  const std::array<int, 2> rows = {band * kBandRows, std::min(grid.height, (band + 1) * kBandRows) - 1};
  for (const Chunk& chunk : chunks) {
    if (chunk.in_band.empty()) continue;  // left out after a stop request
    for (const std::uint32_t k : chunk.in_band[static_cast<std::size_t>(band)]) {
      const ScreenTriangle& triangle = chunk.triangles[k];
      ForEachSample(triangle, is_perspective, rows, [&](int column, int row, float depth) {
        const std::size_t sample =
            static_cast<std::size_t>(row) * static_cast<std::size_t>(grid.width) + static_cast<std::size_t>(column);
        visit(sample, depth, triangle.face);
      });
    }
  }
}

bool IsDrawnBefore(const Fragment& a, const Fragment& b) {
  if (a.sample != b.sample) return a.sample < b.sample;
  if (a.depth != b.depth) return a.depth > b.depth;
  return a.face < b.face;
}

}  // namespace

VisibilityBuffer RasterizeNearest(const CameraMesh& mesh, const PixelSamples& grid, std::stop_token stop) {
  const std::size_t count = static_cast<std::size_t>(grid.width) * static_cast<std::size_t>(grid.height);
  VisibilityBuffer buffer{std::vector<float>(count, std::numeric_limits<float>::infinity()),
                          std::vector<std::uint32_t>(count, kNoFace)};
  const std::vector<Chunk> chunks = SetUpChunks(mesh, grid, stop);
  ForEachBand(BandCount(grid), grid.threads, stop, [&](int band) {
    DrawBand(chunks, grid, band, [&buffer](std::size_t sample, float depth, std::uint32_t face) {
      if (depth < buffer.depth[sample]) {
        buffer.depth[sample] = depth;
        buffer.face[sample] = face;
      }
    });
  });
  return buffer;
}

std::vector<Fragment> RasterizeAll(const CameraMesh& mesh, const PixelSamples& grid,
                                   const std::vector<float>& depth_limit, std::stop_token stop) {
  const std::vector<Chunk> chunks = SetUpChunks(mesh, grid, stop);
  std::vector<std::vector<Fragment>> of_band(static_cast<std::size_t>(BandCount(grid)));
  ForEachBand(BandCount(grid), grid.threads, stop, [&](int band) {
    std::vector<Fragment>& fragments = of_band[static_cast<std::size_t>(band)];
    DrawBand(chunks, grid, band, [&](std::size_t sample, float depth, std::uint32_t face) {
      if (depth < depth_limit[sample]) fragments.push_back({static_cast<std::uint32_t>(sample), face, depth});
    });
    std::sort(fragments.begin(), fragments.end(), IsDrawnBefore);
  });
  std::vector<Fragment> all;
  for (const std::vector<Fragment>& fragments : of_band) all.insert(all.end(), fragments.begin(), fragments.end());
  return all;
}

}  // namespace annulus
