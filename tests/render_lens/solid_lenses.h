#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <optional>

#include "modeling/glasses/lens_form.h"
#include "modeling/glasses/lens_thickness.h"
#include "render/solid_lens.h"
#include "tests/modeling_lens/lens_shapes.h"
#include "tests/support/dice.h"

namespace annulus::test {

/// A unit vector, every direction alike.
inline Eigen::Vector3d Direction(Dice& dice) {
  const double z = dice.Between(-1.0, 1.0);
  const double angle = dice.Between(0.0, kTwoPi);
  const double radius = std::sqrt(1.0 - z * z);
  return {radius * std::cos(angle), radius * std::sin(angle), z};
}

inline Eigen::Isometry3d Placement(Dice& dice, double far) {
  return Eigen::Translation3d(far * Direction(dice)) *
         Eigen::Isometry3d(Eigen::AngleAxisd(dice.Between(0.0, 3.0), Direction(dice)));
}

/// A lens from two surfaces given by vertex, tilt about x and y, turn and curvatures.
struct SurfaceSpec {
  double curvature_u = 0.0;
  double curvature_v = 0.0;
  Eigen::Vector3d vertex = Eigen::Vector3d::Zero();
  double turn = 0.0;    ///< rad, about the axis.
  double tilt_x = 0.0;  ///< rad.
  double tilt_y = 0.0;
};
inline LensSurface Surface(const SurfaceSpec& spec) {
  LensSurface surface;
  surface.lens_from_surface =
      Eigen::Translation3d(spec.vertex) * Eigen::AngleAxisd(spec.tilt_x, Eigen::Vector3d::UnitX()) *
      Eigen::AngleAxisd(spec.tilt_y, Eigen::Vector3d::UnitY()) * Eigen::AngleAxisd(spec.turn, Eigen::Vector3d::UnitZ());
  surface.curvature_u = spec.curvature_u;
  surface.curvature_v = spec.curvature_v;
  return surface;
}

/// A plate of parallel flat sides, its front at z = 0, elliptic, 50 × 36 mm.
inline SolidLens FlatLens(double index, double thickness) {
  SolidLens lens;
  lens.form.back = Surface({0.0, 0.0, {0.0, 0.0, -thickness}});
  lens.form.index = index;
  lens.form.centre_thickness = thickness;
  lens.outline = Ellipse(50.0, 36.0);
  return lens;
}

/// The thinnest lens of an order, base curve by Vogel's rule, elliptic, a × b mm.
struct LensSpec {
  double sphere = 0.0;
  double cylinder = 0.0;  ///< Minus.
  double axis = 0.0;      ///< rad.
  Eigen::Vector2d prism = Eigen::Vector2d::Zero();
  double index = 1.6;
  double a = 52.0;
  double b = 40.0;
};
inline std::optional<SolidLens> MadeLens(const LensSpec& spec) {
  LensFormSpec form;
  const double equivalent = spec.sphere + 0.5 * spec.cylinder;
  form.base = equivalent > 0.0 ? equivalent + 6.0 : 0.5 * equivalent + 6.0;
  form.index = spec.index;
  SolidLens lens;
  lens.outline = Ellipse(spec.a, spec.b);
  const LensOrder order{MatrixFrom({spec.sphere, spec.cylinder, spec.axis}), spec.prism};
  const auto made = ThinnestLensForm(form, order, lens.outline, {});
  if (!made) return std::nullopt;
  lens.form = *made;
  return lens;
}

}  // namespace annulus::test
