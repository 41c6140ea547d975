#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "base/units.h"
#include "modeling/glasses/lens_bevel.h"
#include "modeling/glasses/lens_form.h"
#include "modeling/glasses/lens_material.h"
#include "modeling/glasses/lens_outline.h"
#include "modeling/glasses/lens_power.h"
#include "modeling/glasses/lens_surface.h"
#include "modeling/glasses/lens_thickness.h"
#include "modeling/glasses/lens_trace.h"
#include "modeling/glasses/prescription.h"

namespace annulus {

/// How a worn lens sits before its eye.
struct WornPosition {
  double vertex_distance = 13.0;                      ///< Back of the lens to the cornea, mm; 5…30.
  double pantoscopic_tilt = RadiansFromDegrees(9.0);  ///< rad, lower edge nearer to the face positive; ±30°.
  double face_form_angle = RadiansFromDegrees(4.0);   ///< rad, temporal edge nearer to the face positive; ±35°.
};

/// One rim of the frame: the lens's outline and how it will be worn.
struct RimForLens {
  LensOutline outline;
  WornPosition position;
};
/// What the lenses need to know of the frame.
struct FrameForLenses {
  RimForLens right;
  RimForLens left;
  double dbl = 18.0;  ///< Distance between lenses (boxing), mm; 5…40.

  [[nodiscard]] const RimForLens& of(Eye eye) const { return eye == Eye::kRight ? right : left; }
};

/// Which front curve a lens gets, from the spherical equivalent SE of its power.
enum class BaseCurveRule {
  kVogel,         ///< Plus: SE + 6; minus: SE/2 + 6; kept within 0…16 D.
  kVogelStocked,  ///< The nearest of LensOptions::stocked_bases to it.
  kGiven,         ///< LensOptions::given_base for both eyes.
};
/// Which power the lens is made with.
enum class PowerOrder {
  kAsPrescribed,      ///< The prescription itself.
  kCompensated,       ///< What as worn gives the prescription, prism included (tilt, vertex distance, thickness).
  kCompensatedPower,  ///< The same for the power only; the prism is made as prescribed.
};

/// What the user may choose.
struct LensOptions {
  BaseCurveRule base_rule = BaseCurveRule::kVogel;
  double given_base = 4.0;                                                 ///< D, in the lens's own index; 0…16.
  std::vector<double> stocked_bases{0.5, 1, 2, 3, 4, 5, 6, 7, 8, 10, 12};  ///< D, in the lens's own index.
  PowerModel power_model = PowerModel::kBackVertex;
  PowerOrder power_order = PowerOrder::kCompensated;
  double minimum_centre = 1.5;  ///< mm; 0.3…20: at the optical centre and, 5 mm from the edge on, the thinnest point.
  double minimum_edge = 1.0;    ///< mm; 0.3…20: everywhere on the outline.
  double largest_thickness = 25.0;  ///< mm; a thicker lens is refused.
  double tolerance = 0.13;          ///< D; the largest error of the power as worn in any meridian.
  double blank_allowance = 2.0;     ///< mm, added to ED + 2·decentration.
  std::vector<double> stocked_blanks{50, 55, 60, 65, 70, 75, 80};  ///< mm.
  BevelRule bevel;
  double corridor = 14.0;  ///< mm; progressive corridor that the fitting height is checked for if there is an ADD.
};

/// How grave a remark on a lens is. Whatever makes a lens impossible is an Error instead.
enum class LensSeverity { kNote, kWarning };
struct LensMessage {
  LensSeverity severity{};
  std::string text;  ///< One line, with the reason and what to do.
};

/// A power and prism that somebody orders, reads or gets. Prism: base direction in the front view, cm/m.
struct LensPower {
  SpheroCylinder power;
  Eigen::Vector2d prism = Eigen::Vector2d::Zero();
};

/// The order against what the eye gets. All at the worn vertex distance, in the front view.
struct WornPowerReport {
  LensPower prescribed;              ///< The order, at the vertex distance of the refraction.
  LensPower wanted;                  ///< The order brought to the worn vertex distance.
  LensPower at_cornea;               ///< The order brought to the cornea.
  LensTilt tilt;                     ///< Of the optical axis against the line of sight, decentration's share included.
  LensPower martin;                  ///< The prescription tilted, by Martin's formula (no prism).
  LensPower uncompensated;           ///< Traced: a lens made to the prescription, as worn.
  LensPower to_surface;              ///< What to make (focimeter values): the compensated order, or the prescription.
  LensPower as_worn;                 ///< Traced: this lens as worn.
  double uncompensated_error = 0.0;  ///< D: worst meridian against `wanted`.
  double as_worn_error = 0.0;        ///< D.
  double uncompensated_prism_error = 0.0;  ///< cm/m.
  double as_worn_prism_error = 0.0;        ///< cm/m.
  bool within_tolerance = false;           ///< as_worn_error <= LensOptions::tolerance.
  bool uncompensated_within_tolerance = false;
};

/// The blank that a lens is cut from.
struct BlankReport {
  double minimum = 0.0;           ///< ED + 2·decentration + allowance, mm: the labs' rule, on the safe side.
  double exact = 0.0;             ///< Twice the longest way from the optical centre to the outline + allowance, mm.
  std::optional<double> stocked;  ///< The smallest stocked diameter >= minimum; none: no stocked blank is enough.
};

/// One lens, ready for drawing, rendering and the lab.
struct LensDesign {
  Eye eye{};
  LensBox box;
  Eigen::Vector2d decentration = Eigen::Vector2d::Zero();  ///< Optical centre − box centre, front view, mm.
  double decentration_in = 0.0;                            ///< Towards the nose, mm.
  double fitting_height = 0.0;                             ///< Optical centre above the box's lower side, mm.
  double base = 0.0;                                       ///< Front power in the lens's own index, D.
  LensForm form;
  double front_radius = 0.0;                    ///< mm; infinite if flat.
  std::optional<Eigen::Vector3d> front_centre;  ///< Centre of the front sphere, lens frame, mm; none if flat.
  double back_radius_flat = 0.0;                ///< Principal radii of the back, mm; positive: hollow towards the eye.
  double back_radius_steep = 0.0;
  LensEdge edge;          ///< Along the outline.
  LensBody body;          ///< Volume, weight, centre of gravity.
  double thinnest = 0.0;  ///< mm, over the whole lens.
  double thickest = 0.0;
  LensBevel bevel;
  BlankReport blank;
  WornPowerReport power;
  std::optional<double> add;  ///< Carried only: the blank is computed as single vision.
  std::vector<LensMessage> messages;
};

/// A pair.
struct LensPair {
  LensDesign right;
  LensDesign left;
  LensMaterial material;
  WornPosition position_right;
  WornPosition position_left;
  double dbl = 0.0;                   ///< mm.
  std::string centration;             ///< "confirmed by …", or "estimate, confirm by optician".
  bool centration_confirmed = false;  ///< No lab file may leave without it.
  std::vector<LensMessage> messages;  ///< Of the pair; those of one lens are in its design.
};

/// The front power of the rule, D. `spherical_equivalent` in D.
[[nodiscard]] double BaseCurve(double spherical_equivalent, const LensOptions& options);

/// Designs both lenses: where the optical centres are (PD, heights), base curve, toric back, thickness that keeps both
/// minima over the real outline, prism, the power as worn and what to surface for it, edge, bevel, weight, blank.
/// Refuses what cannot be made, with the reason: an invalid order, material, outline or position; no PD; a pupil
/// outside the outline; surfaces that do not reach the edge; too thick.
[[nodiscard]] Result<LensPair> DesignLensPair(const Prescription& prescription, const LensMaterial& material,
                                              const FrameForLenses& frame, const LensOptions& options);

/// The report: {"format": "annulus-lenses", "version": 1, "material": {…}, "centration": {…}, "right": {…}, "left":
/// {…}, "messages": […]}; keys carry units; axes and angles in degrees.
[[nodiscard]] std::string LensPairToJson(const LensPair& pair);

}  // namespace annulus
