#pragma once

#include <Eigen/Core>
#include <optional>

#include "base/result.h"
#include "modeling/glasses/lens_outline.h"
#include "modeling/glasses/lens_power.h"
#include "modeling/glasses/lens_surface.h"
#include "modeling/glasses/lens_trace.h"

namespace annulus {

/// What a lens's ordered power is: how front and back make it.
enum class PowerModel {
  kBackVertex,  ///< The focimeter reads the order at the reference point: F2 = Fv − F1 / (1 − F1·t/n).
  kThinSum,     ///< F2 = F − F1.
};

/// What the two surfaces are made from besides power and thickness.
struct LensFormSpec {
  double base = 0.0;                                     ///< Front power (n − 1)/R1, D.
  double index = 1.5;                                    ///< > 1.
  Eigen::Vector2d box_centre = Eigen::Vector2d::Zero();  ///< Front vertex: the front stands square to z here, mm.
  Eigen::Vector2d reference = Eigen::Vector2d::Zero();   ///< Optical centre, lens x, y, mm.
  PowerModel model = PowerModel::kBackVertex;
};

/// A power and prism to be made: focimeter values in the lens's x, y; the prism by its base's direction, cm/m (that of
/// a decentred prism is met within 3 mrad, its amount exactly).
struct LensOrder {
  PowerMatrix power = PowerMatrix::Zero();
  Eigen::Vector2d prism = Eigen::Vector2d::Zero();
};

/// The lens of `centre_thickness` mm along the optical axis. Front sphere; the back is the tyre torus whose axis and
/// curvatures make the power, tilted against the front for the prism. Fails if the front does not reach the reference
/// point or light would focus inside.
[[nodiscard]] Result<LensForm> BuildLensForm(const LensFormSpec& spec, const LensOrder& order, double centre_thickness);

/// How thick a lens must be at least, mm.
struct ThicknessRule {
  double minimum_centre = 1.5;  ///< At the reference point, and at the thinnest inner point (MinimumInside).
  double minimum_edge = 1.0;    ///< Everywhere on the outline.
  double largest = 25.0;        ///< A lens that is thicker anywhere is refused.
};
/// What the thinnest inner point must have `from_edge` mm inside the outline: minimum_centre from 5 mm on, towards the
/// edge evenly minimum_edge, so that nothing jumps when a prism moves that point over the edge.
[[nodiscard]] double MinimumInside(const ThicknessRule& rule, double from_edge);

/// The thinnest lens that keeps the rule over `outline`. Fails if a surface does not reach the outline or the lens
/// would be too thick; says by how much.
[[nodiscard]] Result<LensForm> ThinnestLensForm(const LensFormSpec& spec, const LensOrder& order,
                                                const LensOutline& outline, const ThicknessRule& rule);

/// Which prism a compensated lens has.
enum class PrismGoal {
  kAsWorn,     ///< The wanted one as worn: the little prism that tilt and thickness make is taken out.
  kAsOrdered,  ///< The wanted one on the focimeter.
};
/// What an eye should get.
struct WornGoal {
  LensOrder wanted;  ///< Power and prism in the view.
  LensPose pose;
  PrismGoal prism = PrismGoal::kAsWorn;
};
/// A lens whose power as worn is what was wanted.
struct CompensatedForm {
  LensForm form;
  LensOrder order;     ///< What to surface.
  double error = 0.0;  ///< D and cm/m together: the largest remaining error.
};
/// Newton's method on the five numbers of the order (numeric Jacobian of the exact trace), the thickness rule kept.
/// Fails as ThinnestLensForm and TraceAsWorn do, or if it does not converge to 1e-6.
[[nodiscard]] Result<CompensatedForm> CompensatedLensForm(const LensFormSpec& spec, const WornGoal& goal,
                                                          const LensOutline& outline, const ThicknessRule& rule);

/// Where inside the outline the thickness is stationary, if it is a strict minimum or maximum.
struct InnerExtreme {
  Eigen::Vector2d position;
  double thickness = 0.0;  ///< mm, along z.
  bool minimum = false;
};
[[nodiscard]] std::optional<InnerExtreme> InnerExtremeOf(const LensForm& form, const LensOutline& outline);

}  // namespace annulus
