#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "sim/parametric_body.h"
#include "sim/subject.h"

namespace annulus::sim {

/// Hair on the scalp: a layer that returns light from anywhere within its thickness, and little of it.
struct Hair {
  double thickness_mm = 8.0;      ///< mm, > 0; returns come from 0 … thickness above the skin.
  double strand_mm = 4.0;         ///< Size of the locks, mm, > 0.
  double reflectance = 0.4;       ///< 0 … 1, of skin's.
  double front_edge_mm = 1640.0;  ///< Height of the hairline at the front, mm.
  double back_edge_mm = 1500.0;   ///< Height of the hairline at the back, mm.
  double axis_x_mm = 0.0;         ///< Where the head's middle is, mm.
  double axis_y_mm = 0.0;
};

/// A ball of space in which the surface returns less light: a tattoo, dark cloth.
struct DarkPatch {
  Eigen::Vector3d centre;    ///< Station frame at rest, mm.
  double radius_mm = 20.0;   ///< mm, > 0.
  double reflectance = 0.1;  ///< 0 … 1.
};

/// Spectacles on a face: two elliptic rims, a bridge and two arms of round wire; the lenses let light through.
struct WornSpectacles {
  FaceTruth face;                    ///< Where they sit, station frame at rest.
  double rim_half_width_mm = 25.0;   ///< mm.
  double rim_half_height_mm = 19.0;  ///< mm.
  double wire_radius_mm = 1.8;       ///< mm, > 0.
  double frame_reflectance = 0.6;    ///< 0 … 1.
  double lens_transmission = 0.92;   ///< One way, 0 … 1; the beam passes twice.
};

/// What a subject wears. Nothing by default.
struct Dress {
  std::optional<Hair> hair;
  std::optional<WornSpectacles> spectacles;
  std::vector<DarkPatch> dark_patches;
};

/// Another subject with hair, spectacles or dark patches on it. To move the dress with the body, let MovingSubject hold
/// this one. The truth of the bare subject stays what it was. Deterministic; reentrant.
class DressedSubject final : public Subject {
 public:
  /// Requires `bare` and the ranges of `dress`.
  DressedSubject(std::unique_ptr<const Subject> bare, Dress dress);

  [[nodiscard]] std::optional<SubjectHit> Cast(const Ray& ray, double time_s, double max_distance_mm) const override;
  /// With the hair's thickness.
  [[nodiscard]] double top_mm() const override;
  [[nodiscard]] double bottom_mm() const override { return bare_->bottom_mm(); }
  [[nodiscard]] std::string name() const override { return bare_->name(); }

 private:
  // A piece of wire: all points within the wire's radius of a straight line.
  struct Capsule {
    Eigen::Vector3d from, to;
  };
  // An elliptic lens: centre and half axes.
  struct Lens {
    Eigen::Vector3d centre, across, up, forward;
  };

  void BuildSpectacles();
  [[nodiscard]] SubjectHit WithHair(SubjectHit hit, const Eigen::Vector3d& p) const;
  [[nodiscard]] bool PassesLens(const Ray& ray, double distance_mm) const;
  [[nodiscard]] std::optional<SubjectHit> CastWire(const Ray& ray, double max_distance_mm) const;

  std::unique_ptr<const Subject> bare_;
  Dress dress_;
  std::vector<Capsule> wire_;
  std::vector<Lens> lenses_;
  Eigen::Vector3d wire_centre_ = Eigen::Vector3d::Zero();
  double wire_reach_ = 0.0;  // mm, radius of the ball about wire_centre_ that holds all wire
};

}  // namespace annulus::sim
