#pragma once

#include <memory>
#include <optional>
#include <string>

#include "sim/subject.h"

namespace annulus::sim {

/// A cap: a smooth layer over the head above a level rim, and a visor of thin board before the forehead.
struct Cap {
  double rim_mm = 1625.0;         ///< Height of the rim, mm.
  double thickness_mm = 5.0;      ///< Cloth and air between skin and the cap's outside, mm, > 0.
  double visor_mm = 65.0;         ///< How far the visor stands out of the forehead, mm; 0: none.
  double visor_width_mm = 150.0;  ///< mm, > 0.
  double board_mm = 4.0;          ///< Thickness of the visor, mm, > 0.
  double axis_x_mm = 0.0;         ///< Where the head's middle is, mm.
  double axis_y_mm = 0.0;
  double forehead_mm = 92.0;  ///< From there to the forehead, mm.
};

/// A wide shirt: the skin is not seen, but cloth that stands off it in folds, which move slowly with the wearer.
struct LooseClothing {
  double low_mm = 850.0;        ///< Lower hem, mm.
  double high_mm = 1380.0;      ///< Neckline, mm, > low_mm.
  double ease_mm = 12.0;        ///< Mean distance of the cloth from the skin, mm, >= 0.
  double fold_mm = 24.0;        ///< Height of the folds from valley to ridge, mm, >= 0; no cloth lies inside the skin.
  double fold_width_mm = 45.0;  ///< Width of a fold, mm, > 0; folds are three times as long as wide.
  double flutter_s = 4.0;       ///< s; after so long a place has another fold. > 0.
};

/// Another subject in clothes that hide its shape. To move them with the body, let MovingSubject hold this one.
/// Deterministic; reentrant.
class ClothedSubject final : public Subject {
 public:
  /// Requires `bare` and the ranges of what is worn.
  ClothedSubject(std::unique_ptr<const Subject> bare, std::optional<Cap> cap, std::optional<LooseClothing> clothing);

  [[nodiscard]] std::optional<SubjectHit> Cast(const Ray& ray, double time_s, double max_distance_mm) const override;
  /// With the cap's thickness.
  [[nodiscard]] double top_mm() const override { return bare_->top_mm() + (cap_ ? cap_->thickness_mm : 0.0); }
  [[nodiscard]] double bottom_mm() const override { return bare_->bottom_mm(); }
  [[nodiscard]] std::string name() const override { return bare_->name(); }

 private:
  [[nodiscard]] std::optional<SubjectHit> CastVisor(const Ray& ray, double max_distance_mm) const;
  /// How far the cloth stands off a place of the skin, mm.
  [[nodiscard]] double ClothAt(const Eigen::Vector3d& p, double time_s) const;

  std::unique_ptr<const Subject> bare_;
  std::optional<Cap> cap_;
  std::optional<LooseClothing> clothing_;
};

}  // namespace annulus::sim
