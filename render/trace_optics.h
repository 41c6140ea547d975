#pragma once

#include <cstdint>
#include <limits>
#include <optional>

#include "render/light_path.h"
#include "render/trace.h"
#include "render/trace_scene.h"

namespace annulus {

/// The nearest boundary of a lens, or the nearest lens sheet, on a path.
struct OpticalEvent {
  float t = std::numeric_limits<float>::infinity();  ///< Infinite: none.
  int lens = LightPath::kNoLens;                     ///< kNoLens with a finite t: a sheet.
  LensCrossing crossing{};
  TraceHit sheet{};
};

/// What lenses do to paths. From the eye to the first rough surface a path is refracted and mirrored exactly. After
/// that it goes straight through: at each boundary it is mirrored with the probability R and passes with 1 − R, dimmed
/// by the glass, so that no light is lost; shadow rays count the passing share only. Borrows the scene.
class TraceOptics {
 public:
  TraceOptics(const TraceScene& scene, Dispersion dispersion) : scene_(scene), dispersion_(dispersion) {}

  /// Whether the scene has any.
  [[nodiscard]] bool exist() const { return !scene_.optics_boxes().empty(); }
  /// What `path` meets first.
  [[nodiscard]] OpticalEvent Next(const LightPath& path) const;
  /// Takes `path` through the boundary of `event`. From the eye both ways are followed at the first two boundaries: the
  /// path returned is the mirrored one.
  [[nodiscard]] std::optional<LightPath> Pass(const OpticalEvent& event, LightPath& path) const;
  /// Dims a path in glass by its way of `length` mm to a rough surface within the glass.
  void Absorb(float length, LightPath& path) const;
  /// What is left of light that comes straight along `ray`, which starts in the glass of lens `inside` or in air.
  [[nodiscard]] LinearRgb StraightThrough(const TraceRay& ray) const;

 private:
  struct Boundary;

  [[nodiscard]] LensRay InStation(const TraceRay& ray) const;
  [[nodiscard]] LinearRgb InGlass(int lens, const Eigen::Vector3d& from, const Eigen::Vector3d& to) const;
  [[nodiscard]] Boundary BoundaryAt(const OpticalEvent& event, const LightPath& path) const;
  void GoOn(const OpticalEvent& event, const Boundary& boundary, LightPath& path) const;
  void Mirror(const OpticalEvent& event, const Boundary& boundary, LightPath& path) const;

  const TraceScene& scene_;
  Dispersion dispersion_;
};

}  // namespace annulus
