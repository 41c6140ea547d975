#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "modeling/measure/string_system.h"
#include "modeling/measure/surface_path.h"

namespace annulus {

/// What a vertex of a string may do.
enum class VertexHold {
  kSliding,  ///< Goes where the string pulls it.
  kHeld,     ///< Stays in its half plane of theta and at its height; may rise off the surface outward.
  kFixed,    ///< Does not move.
};

/// A vertex of a string: on the surface or, where the string spans, off it.
struct StringVertex {
  SurfacePlace place;                                  ///< Where it lies, or what lies under it towards the axis.
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< Station frame, mm.
  VertexHold hold = VertexHold::kSliding;
  bool touches = true;  ///< Whether it lies on the surface.
  double share = 1.0;   ///< Of the string's length: that of the edge to the next vertex. > 0.
};

/// Where a string may lie.
enum class StringSide {
  kOnSurface,  ///< On the surface: taut, it is a geodesic.
  kOutside,    ///< On the surface or outside it: taut, it is a tape that spans hollows.
};

/// What binds a whole string.
struct StringRules {
  StringSide side = StringSide::kOnSurface;
  PathEnds ends = PathEnds::kOpen;
  double z_min = 0.0;  ///< mm; it may run along this height.
  double z_max = 0.0;  ///< mm
};

/// A vertex of a sliding string at a point of the station frame, mm: pushed out to the surface if the point is inside.
[[nodiscard]] StringVertex VertexNear(const SplineSurface& surface, const StringRules& rules,
                                      const Eigen::Vector3d& position);
/// A vertex on the surface.
[[nodiscard]] StringVertex VertexAt(const SplineSurface& surface, const SurfacePlace& place);

/// When to stop.
struct TightenEffort {
  int most_steps = 0;
  double least_gain = 0.0;  ///< Share of the energy that a step must gain for another one to follow.
};

/// A string over a surface r(theta, z), pulled taut by minimising its energy ½ Σ |P_{k+1} - P_k|² / share_k: at the
/// minimum all edges have the same tension |P_{k+1} - P_k| / share_k and the string is as short as it can be nearby.
/// Newton's method with the exact Hessian (block tridiagonal, 3 × 3), an active set of the vertices that touch, and
/// projection of every trial; the energy never grows. Borrows the surface. Thread-bound.
class TautString {
 public:
  /// Requires >= 3 vertices; the ends of an open string must be fixed. Shares are scaled to the sum 1.
  TautString(const SplineSurface& surface, const StringRules& rules, std::vector<StringVertex> vertices);

  [[nodiscard]] const StringRules& rules() const { return rules_; }
  [[nodiscard]] const std::vector<StringVertex>& vertices() const { return vertices_; }
  [[nodiscard]] std::size_t edge_count() const;
  /// Length of the polygon, mm.
  [[nodiscard]] double Length() const;

  /// Pulls the string taut, as far as the effort goes.
  void Tighten(const TightenEffort& effort);
  /// Divides edge k into `parts[k]` >= 1 parts. Requires one number per edge.
  void Split(const std::vector<std::size_t>& parts);
  /// Sets the shares to the edges' lengths: vertices that are held then do not favour any side.
  void ShareByLength();

 private:
  struct System;
  struct VertexModel;

  [[nodiscard]] std::size_t Next(std::size_t k) const { return k + 1 < vertices_.size() ? k + 1 : 0; }
  [[nodiscard]] double Energy(const std::vector<StringVertex>& vertices) const;
  /// ∂energy/∂P_k.
  [[nodiscard]] Eigen::Vector3d Pull(std::size_t k) const;
  [[nodiscard]] System Linearise() const;
  [[nodiscard]] VertexModel LineariseVertex(std::size_t k) const;
  /// Moves towards the minimum of a model of the energy. The energy gained; 0 where no gain is left; negative where the
  /// model does not serve.
  double Step(const System& system, const ChainSystem& model, double energy);
  [[nodiscard]] std::vector<StringVertex> Moved(const System& system, const std::vector<Eigen::Vector3d>& step,
                                                double factor) const;

  const SplineSurface* surface_;
  StringRules rules_;
  std::vector<StringVertex> vertices_;
};

}  // namespace annulus
