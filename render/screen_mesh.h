#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <stop_token>
#include <vector>

#include "render/clip.h"
#include "render/rasterizer.h"

namespace annulus {

/// Rows of samples that one thread draws at a time.
inline constexpr int kBandRows = 32;
/// Vertices are rounded to 1/256 sample, so that the edge functions are exact integers and a shared edge is seen
/// identically from both sides.
inline constexpr std::int64_t kSubsample = 256;

/// A triangle that is ready to be drawn.
struct ScreenTriangle {
  std::array<std::int64_t, 3> x{};  ///< 1/256 sample, to the right; the corners turn so that edge functions are >= 0.
  std::array<std::int64_t, 3> y{};  ///< 1/256 sample, downwards.
  /// Perspective: 1 / depth, orthographic: depth, at (column, row) centres = at_origin + per_column * x + per_row * y.
  double at_origin = 0.0;
  double per_column = 0.0;
  double per_row = 0.0;
  double nearest = 0.0;   ///< mm.
  double farthest = 0.0;  ///< mm.
  std::uint32_t face = 0;
  int column_from = 0;
  int column_to = -1;
  int row_from = 0;
  int row_to = -1;
};

/// A mesh on the sample grid: its vertices rounded, its faces sorted into bands of rows. Most faces need no clipping
/// and are set up only when they are drawn, which keeps the memory at a few bytes per face.
/// Borrows mesh and grid, which outlive it.
class ScreenMesh {
 public:
  ScreenMesh(const CameraMesh& mesh, const PixelSamples& grid, const std::stop_token& stop);

  [[nodiscard]] const PixelSamples& grid() const { return grid_; }
  [[nodiscard]] int band_count() const { return (grid_.height + kBandRows - 1) / kBandRows; }
  /// See RasterizeNearest.
  [[nodiscard]] SampleWindow Window() const;

  /// Calls visit for every triangle that may touch a sample of the band, in the order of the faces.
  template <class Visit>
  void ForEachTriangle(int band, Visit&& visit) const {
    for (std::size_t index = 0; index < chunks_.size(); ++index) {
      const Chunk& chunk = chunks_[index];
      if (chunk.band_begin.empty()) continue;  // left out after a stop request
      const std::size_t to = chunk.band_begin[static_cast<std::size_t>(band) + 1];
      for (std::size_t k = chunk.band_begin[static_cast<std::size_t>(band)]; k < to; ++k) {
        const std::uint32_t entry = chunk.entries[k];
        if ((entry & kClipped) != 0U) {
          visit(chunk.clipped[entry & ~kClipped]);
        } else {
          ScreenTriangle triangle;
          triangle.face = static_cast<std::uint32_t>(index * kChunkFaces) + entry;
          if (SetUp(triangle)) visit(triangle);
        }
      }
    }
  }

 private:
  static constexpr std::size_t kChunkFaces = 4096;
  static constexpr std::uint32_t kClipped = 0x80000000U;
  static constexpr std::int32_t kOffGrid = INT32_MIN;

  /// 1/256 sample; x is kOffGrid where faces at the vertex must be clipped.
  struct Vertex {
    std::int32_t x = kOffGrid;
    std::int32_t y = 0;
  };
  /// Some faces by band: entries[band_begin[b]] … are those of band b, in the order of the faces. An entry is the
  /// face's number within the chunk, or with kClipped the number of a piece of one.
  struct Chunk {
    std::vector<std::uint32_t> entries;
    std::vector<std::uint32_t> band_begin;
    std::vector<ScreenTriangle> clipped;
  };
  struct Span {
    std::uint32_t entry = 0;
    int band_from = 0;
    int band_to = 0;
  };

  void Project(const std::stop_token& stop);
  [[nodiscard]] Vertex ToGrid(const Eigen::Vector3d& p) const;
  [[nodiscard]] Chunk SortChunk(std::size_t index) const;
  /// Appends the pieces of a face that must be clipped.
  void AddClipped(std::uint32_t face, Chunk& chunk, std::vector<Span>& spans) const;
  /// Completes a triangle of which only the face is known; false if there is nothing to draw.
  [[nodiscard]] bool SetUp(ScreenTriangle& triangle) const;
  [[nodiscard]] bool SetBounds(ScreenTriangle& triangle) const;
  [[nodiscard]] bool SetDepthPlane(const Eigen::Vector3d& normal, double offset, ScreenTriangle& triangle) const;
  [[nodiscard]] bool AddPiece(ScreenTriangle triangle, const std::array<Eigen::Vector3d, 3>& corners,
                              std::vector<ScreenTriangle>& pieces) const;

  const CameraMesh& mesh_;
  const PixelSamples& grid_;
  std::array<ClipPlane, 5> view_planes_;
  std::array<ClipPlane, 5> guard_planes_;
  std::vector<Vertex> vertices_;
  std::vector<Chunk> chunks_;
};

}  // namespace annulus
