#include "render/rasterizer.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "base/bands.h"
#include "render/screen_mesh.h"

namespace annulus {
namespace {

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

/// Draws all triangles of a band in the order of their faces, whatever thread does it: visit(column, row, face, depth).
template <class Visit>
void DrawBand(const ScreenMesh& screen, int band, Visit&& visit) {
  const PixelSamples& grid = screen.grid();
  const bool is_perspective = grid.projection == Projection::kPerspective;
  const std::array<int, 2> rows = {band * kBandRows, std::min(grid.height, (band + 1) * kBandRows) - 1};
  screen.ForEachTriangle(band, [&](const ScreenTriangle& triangle) {
    ForEachSample(triangle, is_perspective, rows,
                  [&](int column, int row, float depth) { visit(column, row, triangle.face, depth); });
  });
}

bool IsDrawnBefore(const Fragment& a, const Fragment& b) {
  if (a.sample != b.sample) return a.sample < b.sample;
  if (a.depth != b.depth) return a.depth > b.depth;
  return a.face < b.face;
}

}  // namespace

VisibilityBuffer RasterizeNearest(const CameraMesh& mesh, const PixelSamples& grid, std::stop_token stop) {
  const ScreenMesh screen(mesh, grid, stop);
  VisibilityBuffer buffer;
  buffer.window = screen.Window();
  buffer.depth.assign(buffer.window.Count(), std::numeric_limits<float>::infinity());
  buffer.face.assign(buffer.window.Count(), kNoFace);
  if (buffer.window.IsEmpty()) return buffer;
  ForEachBand(screen.band_count(), grid.threads, stop, [&](int band) {
    DrawBand(screen, band, [&buffer](int column, int row, std::uint32_t face, float depth) {
      const std::size_t sample = buffer.window.Index(column, row);
      if (depth < buffer.depth[sample]) {
        buffer.depth[sample] = depth;
        buffer.face[sample] = face;
      }
    });
  });
  return buffer;
}

std::vector<Fragment> RasterizeAll(const CameraMesh& mesh, const PixelSamples& grid, const DepthLimit& limit,
                                   std::stop_token stop) {
  const ScreenMesh screen(mesh, grid, stop);
  std::vector<std::vector<Fragment>> of_band(static_cast<std::size_t>(screen.band_count()));
  ForEachBand(screen.band_count(), grid.threads, stop, [&](int band) {
    std::vector<Fragment>& fragments = of_band[static_cast<std::size_t>(band)];
    DrawBand(screen, band, [&](int column, int row, std::uint32_t face, float depth) {
      if (!(depth < limit.At(column, row))) return;
      const auto sample =
          static_cast<std::uint32_t>(row) * static_cast<std::uint32_t>(grid.width) + static_cast<std::uint32_t>(column);
      fragments.push_back({sample, face, depth});
    });
    std::sort(fragments.begin(), fragments.end(), IsDrawnBefore);
  });
  std::vector<Fragment> all;
  for (const std::vector<Fragment>& fragments : of_band) all.insert(all.end(), fragments.begin(), fragments.end());
  return all;
}

}  // namespace annulus
