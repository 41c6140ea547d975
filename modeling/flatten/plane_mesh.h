#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include "base/result.h"

namespace annulus {

/// Triangles of a region of the plane whose sides are made Delaunay by flips: in the plane while it is built, on a
/// surface that lies over the plane afterwards. Given lines stay sides (constrained Delaunay triangulation: Lawson
/// 1977, Sloan 1993).
class PlaneMesh {
 public:
  /// The surface over the plane: where a point lies in space, mm.
  using Lift = std::function<Eigen::Vector3d(const Eigen::Vector2d&)>;

  static constexpr std::uint32_t kNone = 0xffffffffU;
  struct Triangle {
    std::array<std::uint32_t, 3> vertex{};                     ///< Counter-clockwise.
    std::array<std::uint32_t, 3> across{kNone, kNone, kNone};  ///< Beyond the side from corner k to the next.
    std::array<bool, 3> fixed{};                               ///< Whether that side is part of a given line.
  };
  /// Lines between numbered points.
  using Chain = std::vector<std::uint32_t>;
  /// What a region is made of.
  struct Lines {
    std::vector<Eigen::Vector2d> points;  ///< First the rim's corners, counter-clockwise, then those inside.
    std::size_t rim_count = 0;            ///< >= 3
    std::size_t held_count = 0;           ///< So many points stay where they are, >= rim_count; the others may move.
    std::vector<Chain> chains;            ///< Lines inside the rim, between held points.
  };

  /// The region inside the rim. Fails if lines cross, or points coincide or lie outside.
  [[nodiscard]] static Result<PlaneMesh> Fill(const Lines& lines);

  [[nodiscard]] const std::vector<Eigen::Vector2d>& points() const { return points_; }
  [[nodiscard]] const std::vector<Triangle>& triangles() const { return triangles_; }

  /// Cuts sides until none inside the rim is longer than `longest` on the surface, mm, and evens the triangles out.
  /// Given points and lines stay. Fails if more than `most` triangles would be needed.
  Status Refine(const Lift& lift, double longest, std::size_t most);

 private:
  PlaneMesh() = default;

  struct Corner {
    std::uint32_t triangle = kNone;
    std::uint8_t side = 0;
  };

  void BeginAround(const std::vector<Eigen::Vector2d>& points);
  [[nodiscard]] std::uint32_t Locate(const Eigen::Vector2d& p);
  bool Insert(std::uint32_t vertex);
  bool FixLine(std::uint32_t from, std::uint32_t to);
  [[nodiscard]] Corner FindSide(std::uint32_t from, std::uint32_t to) const;
  [[nodiscard]] bool FlipAwayCrossing(std::uint32_t from, std::uint32_t to);
  void RemoveOutside(std::size_t given);

  void Join(std::uint32_t t, std::size_t side, std::uint32_t u);
  void Flip(std::uint32_t t, std::size_t side);
  void SplitTriangle(std::uint32_t t, std::uint32_t vertex);
  void SplitSide(std::uint32_t t, std::size_t side, std::uint32_t vertex);
  void Legalise(std::uint32_t t, std::size_t side, int depth);
  [[nodiscard]] bool ShouldFlip(std::uint32_t t, std::size_t side) const;
  [[nodiscard]] bool IsConvexAcross(std::uint32_t t, std::size_t side) const;
  [[nodiscard]] double Turn(std::uint32_t a, std::uint32_t b, std::uint32_t c) const;
  [[nodiscard]] std::size_t SideTo(std::uint32_t t, std::uint32_t u) const;

  std::size_t SplitLong(double longest);
  void FlipAll();
  void Even();

  std::vector<Eigen::Vector2d> points_;
  std::vector<Eigen::Vector3d> lifted_;  ///< Empty while the mesh is built.
  std::vector<Triangle> triangles_;
  Lift lift_;
  std::size_t given_ = 0;
  std::uint32_t last_ = 0;
};

}  // namespace annulus
