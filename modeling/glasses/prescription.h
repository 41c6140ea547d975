#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "base/result.h"
#include "modeling/glasses/lens_outline.h"

namespace annulus {

/// A prismatic effect as it is prescribed, in prism dioptres (cm/m), by where the base lies.
struct Prism {
  double in = 0.0;  ///< Base in (towards the nose) positive, base out negative.
  double up = 0.0;  ///< Base up positive, base down negative.

  [[nodiscard]] bool operator==(const Prism&) const = default;
};

/// The prism of `magnitude` cm/m whose base lies at `base_deg` (0…360°, counter-clockwise from the viewer's right as
/// the prescriber sees the wearer): 0° is base in for the right eye and base out for the left.
[[nodiscard]] Prism PrismFromBase(double magnitude, double base_deg, Eye eye);

/// What is ordered for one eye, as it is written on the order: dioptres, degrees, mm. The axis is kept in degrees (not
/// radians, as elsewhere inside) so that an order reads back to the same bits.
struct EyePrescription {
  double sphere = 0.0;             ///< SPH, D; -30…30, and so is SPH + CYL.
  double cylinder = 0.0;           ///< CYL, D; either sign (minus- or plus-cylinder form); -15…15.
  std::optional<double> axis_deg;  ///< TABO: counter-clockwise from the viewer's right; 0…180. Needed if CYL is not 0.
  Prism prism;                     ///< At most 20 cm/m together.
  std::optional<double> add;       ///< ADD, D; 0.25…4.00; none: single vision.
  std::optional<double> pd;        ///< Monocular pupillary distance, from the bridge's middle, mm; 20…45.
  std::optional<double> height;    ///< Fitting height, from the box's lower side to the pupil, mm; 5…60.

  [[nodiscard]] bool operator==(const EyePrescription&) const = default;
};

/// The vertex distance of an order that does not say at which it was refracted, mm.
inline constexpr double kUsualRefractedVertex = 12.0;

/// An order for a pair of lenses: RX.json.
struct Prescription {
  EyePrescription right;
  EyePrescription left;
  std::string date;                        ///< "YYYY-MM-DD".
  std::string prescriber;                  ///< Name; not empty.
  std::optional<double> refracted_vertex;  ///< Vertex distance of the refraction, mm; 5…25.
  /// Name of who confirmed the PDs and heights. Empty: they are an estimate and must be confirmed by an optician before
  /// any lab file leaves.
  std::string centration_confirmed_by;

  [[nodiscard]] const EyePrescription& of(Eye eye) const { return eye == Eye::kRight ? right : left; }
  [[nodiscard]] bool centration_confirmed() const { return !centration_confirmed_by.empty(); }
  [[nodiscard]] bool operator==(const Prescription&) const = default;
};

/// Whether a lens can be ordered so. The error names the eye, the field, its value and what is permitted.
[[nodiscard]] Status Validate(const Prescription& prescription);

/// The same power in the other cylinder form: SPH + CYL, -CYL, axis ± 90° in (0, 180]; without cylinder it is returned
/// with its axis as it was. Exact for powers and axes of up to six decimals: twice is the same order again (axis 0
/// reads 180).
[[nodiscard]] EyePrescription Transposed(const EyePrescription& order);
/// The minus-cylinder (CYL <= 0) or plus-cylinder (CYL >= 0) form.
[[nodiscard]] EyePrescription InMinusCylinder(const EyePrescription& order);
[[nodiscard]] EyePrescription InPlusCylinder(const EyePrescription& order);

/// Where a pupil is, as measured on a scan, mm; as in EyePrescription.
struct MeasuredPupil {
  double pd = 0.0;
  double height = 0.0;
};
/// `prescription` with PDs and heights that it lacks taken from a measurement. If any was taken the centration counts
/// as an estimate again.
[[nodiscard]] Prescription WithMeasuredPupils(const Prescription& prescription, const MeasuredPupil& right,
                                              const MeasuredPupil& left);

/// RX.json:
/// {"format": "annulus-rx", "version": 1, "date": "2026-05-04", "prescriber": "…", "refracted_vertex_mm": 12,
///  "right": {"sph_d": -4, "cyl_d": -0.75, "axis_deg": 90, "prism": …, "add_d": 2, "pd_mm": 31.5, "height_mm": 20},
///  "left": {…}, "centration": {"status": "confirmed", "confirmed_by": "…"}}
/// where "prism" is {"horizontal_cm_m": 1, "horizontal_base": "in"|"out", "vertical_cm_m": 0.5, "vertical_base":
/// "up"|"down"} (either half may be left out) or {"magnitude_cm_m": 2, "base_deg": 90}, and "centration" is {"status":
/// "estimate"} if nobody confirmed. Required: format, version, date, prescriber, right, left, sph_d. Numbers read back
/// to the same bits; a prism is written in the first form.
[[nodiscard]] std::string PrescriptionToJson(const Prescription& prescription);
/// Reads RX.json and validates. Strict: an unknown or repeated key, a number written as text, a value out of range are
/// refused with the field's name. `name` of the file is for messages.
[[nodiscard]] Result<Prescription> PrescriptionFromJson(std::string_view json, std::string_view name);

}  // namespace annulus
