#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "base/result.h"
#include "modeling/wrinkly/base_surface.h"
#include "modeling/wrinkly/control_mesh.h"
#include "modeling/wrinkly/mesh_shuffle.h"

namespace annulus {

/// How values at a number of iterations between whole ones are made.
enum class LevelBlend {
  kTwo,   ///< (1 − t)·h_K + t·h_{K+1}: at whole K the paper's surface.
  kFour,  ///< (1 − t, 2 − t, 1 + t, t)/4 of K − 1 … K + 2: half as large steps in a zoom, never a single K.
};

/// How a control mesh becomes a wrinkly surface.
struct WrinklyOptions {
  /// M_U and M_V of every iteration (paper 003, §2.2). `structure`, if given, has an M for each iteration instead, the
  /// same for both families: the surface then has as many iterations as it has entries.
  int crossing_u = 1;
  int crossing_v = 1;
  std::vector<int> structure{};
  double u_then_v = 0.5;  ///< α_0 of eq. 12, 0 … 1; α_1 = 1 − α_0.
  CornerJoin join = CornerJoin::kPaper;
  LevelBlend blend = LevelBlend::kTwo;
};

/// A wrinkly surface R(t) = P(t) + [P_IST(H)](t) · N(t) (paper 003, eq. 15), and everything else that its control
/// points carry, at any number of iterations K. Whole numbers K are the paper's; between two of them values are (1 −
/// t)·h_K + t·h_{K+1}, since a change of K alone moves every point by about the RMS height. K = 0 is the smooth
/// surface. A value; thread-safe.
class WrinklySurface {
 public:
  /// Fails as BaseSurface::Make and Shuffle::Make, and if α_0 is out of range.
  static Result<WrinklySurface> Make(ControlMesh mesh, const WrinklyOptions& options);
  WrinklySurface(WrinklySurface&&) = default;
  WrinklySurface& operator=(WrinklySurface&&) = default;

  [[nodiscard]] const ControlMesh& mesh() const { return *mesh_; }
  [[nodiscard]] const BaseSurface& base() const { return base_; }
  /// Most iterations: those of `structure`, or as many as keep parts of a patch countable (19 for M = 1).
  [[nodiscard]] int most_iterations() const { return static_cast<int>(levels_.size()) - 1; }
  /// The transformation with k iterations, 0 … most_iterations().
  [[nodiscard]] const MeshShuffle& level(int k) const { return levels_[static_cast<std::size_t>(k)]; }
  [[nodiscard]] std::size_t attribute_count() const { return mesh_->parts().attributes.size(); }
  /// Of an attribute's name.
  [[nodiscard]] std::optional<std::size_t> AttributeNamed(std::string_view name) const;
  /// α_0 of eq. 12.
  [[nodiscard]] double u_then_v() const { return u_then_v_; }
  /// Between which heights every place lies, mm; 0 is within.
  [[nodiscard]] double lowest_height() const { return lowest_height_; }
  [[nodiscard]] double highest_height() const { return highest_height_; }

  /// All attributes at a place of the grid of `depth` iterations as `iterations` of them (0 … most_iterations())
  /// shuffle it (eq. 12): with fewer, the finer digits are the offset within, with more, the offset has them. Requires
  /// values.size() == attribute_count(), or 1 for the height alone.
  void Values(const MeshPlace& place, int depth, double iterations, std::span<float> values) const;
  /// The height alone, mm.
  [[nodiscard]] double Height(const MeshPlace& place, int depth, double iterations) const;
  /// The same of attributes as they are interpolated, without a shuffle (eq. 14); u, v in 0 … 1.
  void SmoothValues(PointIndex patch, double u, double v, std::span<float> values) const;

 private:
  WrinklySurface(std::unique_ptr<const ControlMesh> mesh, BaseSurface base)
      : mesh_(std::move(mesh)), base_(std::move(base)) {}
  void FillNets();
  void AddLevel(const MeshPlace& place, int depth, int iterations, double weight, std::span<float> values) const;
  void AddSmooth(const MeshPlace& place, const MeshShuffle& shuffle, double weight, std::span<float> values) const;

  std::unique_ptr<const ControlMesh> mesh_;  ///< On the heap: levels borrow it.
  BaseSurface base_;
  std::vector<MeshShuffle> levels_;
  LevelBlend blend_ = LevelBlend::kTwo;
  double u_then_v_ = 0.5;
  double lowest_height_ = 0.0;
  double highest_height_ = 0.0;
  std::vector<float> nets_;  ///< Patch by patch, attribute by attribute: 3 × 3 as in PatchNet.
};

}  // namespace annulus
