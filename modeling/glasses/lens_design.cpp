#include "modeling/glasses/lens_design.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace annulus {
namespace {

constexpr const char* kAttempt = "design the lenses";
constexpr double kFlattestBase = 0.0;   // D
constexpr double kSteepestBase = 16.0;  // D
constexpr std::size_t kEdgePoints = 360;
constexpr double kBlankSlack = 1e-6;  // mm, rounding

/// What is known of one lens before its surfaces.
struct EyeTask {
  Eye eye{};
  const EyePrescription& order;
  const RimForLens& rim;
  const LensMaterial& material;
  const LensOptions& options;
  double refracted_vertex = kUsualRefractedVertex;
  double dbl = 0.0;
};

const char* EyeName(Eye eye) { return eye == Eye::kRight ? "right" : "left"; }

/// +1 if the nose is at the viewer's right.
double NoseSide(Eye eye) { return eye == Eye::kRight ? 1.0 : -1.0; }

Status InRange(const std::string& what, double value, double low, double high) {
  if (value >= low && value <= high) return {};  // NaN is not
  return Fail(kAttempt, fmt::format("{} is {:.4g}, outside {:.4g} to {:.4g}", what, value, low, high),
              "correct the value");
}

Status AllInRange(const std::string& what, const std::vector<double>& values, double low, double high) {
  if (values.empty()) return Fail(kAttempt, fmt::format("there are no {}", what), "give at least one");
  for (const double value : values) RETURN_IF_ERROR(InRange(fmt::format("one of the {}", what), value, low, high));
  return {};
}

Status ValidateOptions(const LensOptions& options) {
  RETURN_IF_ERROR(InRange("the given base curve in D", options.given_base, kFlattestBase, kSteepestBase));
  RETURN_IF_ERROR(AllInRange("stocked base curves in D", options.stocked_bases, kFlattestBase, kSteepestBase));
  RETURN_IF_ERROR(InRange("the minimum centre thickness in mm", options.minimum_centre, 0.3, 20.0));
  RETURN_IF_ERROR(InRange("the minimum edge thickness in mm", options.minimum_edge, 0.3, 20.0));
  RETURN_IF_ERROR(InRange("the largest thickness in mm", options.largest_thickness, 1.0, 50.0));
  RETURN_IF_ERROR(InRange("the tolerance in D", options.tolerance, 0.01, 1.0));
  RETURN_IF_ERROR(InRange("the blank allowance in mm", options.blank_allowance, 0.0, 20.0));
  RETURN_IF_ERROR(AllInRange("stocked blanks in mm", options.stocked_blanks, 20.0, 120.0));
  RETURN_IF_ERROR(InRange("the bevel's distance from the front in mm", options.bevel.front_distance, 0.3, 20.0));
  RETURN_IF_ERROR(InRange("the bevel's share of the edge", options.bevel.ratio, 0.1, 0.9));
  RETURN_IF_ERROR(InRange("the bevel's curve in D", options.bevel.curve, 0.0, 12.0));
  RETURN_IF_ERROR(InRange("the bevel's width in mm", options.bevel.width, 0.5, 5.0));
  return InRange("the progressive corridor in mm", options.corridor, 6.0, 25.0);
}

Status ValidateRim(const RimForLens& rim, Eye eye) {
  const std::string name = EyeName(eye);
  RETURN_IF_ERROR(Validate(rim.outline));
  RETURN_IF_ERROR(InRange(fmt::format("the {} lens's boxed width in mm", name), BoxOf(rim.outline).a, 15.0, 90.0));
  RETURN_IF_ERROR(InRange(fmt::format("the {} lens's boxed height in mm", name), BoxOf(rim.outline).b, 10.0, 80.0));
  RETURN_IF_ERROR(InRange(fmt::format("the {} vertex distance in mm", name), rim.position.vertex_distance, 5.0, 30.0));
  RETURN_IF_ERROR(InRange(fmt::format("the {} pantoscopic tilt in degrees", name),
                          DegreesFromRadians(rim.position.pantoscopic_tilt), -30.0, 30.0));
  return InRange(fmt::format("the {} face-form angle in degrees", name),
                 DegreesFromRadians(rim.position.face_form_angle), -35.0, 35.0);
}

PowerMatrix PrescribedPower(const EyePrescription& order) {
  return MatrixFrom({order.sphere, order.cylinder, RadiansFromDegrees(order.axis_deg.value_or(180.0))});
}

Eigen::Vector2d PrescribedPrism(const EyePrescription& order, Eye eye) {
  return {NoseSide(eye) * order.prism.in, order.prism.up};
}

LensPower PowerFrom(const PowerMatrix& power, const Eigen::Vector2d& prism) {
  return {SpheroCylinderFrom(power), prism};
}

void Warn(LensDesign& design, std::string text) {
  design.messages.push_back({LensSeverity::kWarning, std::move(text)});
}
void Note(LensDesign& design, std::string text) { design.messages.push_back({LensSeverity::kNote, std::move(text)}); }

/// Where the pupil meets the lens: PD and height in the outline's frame. Face form shortens the box seen from the
/// front.
Status PlaceOpticalCentre(const EyeTask& task, LensDesign& design) {
  if (!task.order.pd) {
    return Fail(kAttempt, fmt::format("the {} eye has no PD", EyeName(task.eye)),
                "measure the monocular PD, or take it from the scan as an estimate");
  }
  const LensBox& box = design.box;
  const double from_nasal_side = (*task.order.pd - task.dbl / 2.0) / std::cos(task.rim.position.face_form_angle);
  design.decentration_in = box.a / 2.0 - from_nasal_side;
  if (task.order.height) {
    design.fitting_height = *task.order.height;
  } else {
    design.fitting_height = box.b / 2.0;
    Warn(design, "no fitting height is given: the optical centre is at half the lens's height; measure it");
  }
  design.decentration = {NoseSide(task.eye) * design.decentration_in, design.fitting_height - box.b / 2.0};
  const Eigen::Vector2d centre = box.centre + design.decentration;
  if (!Inside(task.rim.outline, centre)) {
    return Fail(kAttempt,
                fmt::format("the {} pupil is {:.1f} mm inwards and {:.1f} mm above the middle of its lens, outside the "
                            "outline",
                            EyeName(task.eye), design.decentration_in, design.decentration.y()),
                "choose a frame that fits, or check PD and height");
  }
  return {};
}

/// The spec of both lenses, compensated and not.
LensFormSpec SpecOf(const EyeTask& task, const LensDesign& design) {
  LensFormSpec spec;
  spec.base = design.base;
  spec.index = task.material.index;
  spec.box_centre = design.box.centre;
  spec.reference = design.box.centre + design.decentration;
  spec.model = task.options.power_model;
  return spec;
}

/// Shapes the lens and fills the power report.
Status ShapeLens(const EyeTask& task, LensDesign& design) {
  const LensFormSpec spec = SpecOf(task, design);
  const ThicknessRule rule{task.options.minimum_centre, task.options.minimum_edge, task.options.largest_thickness};
  const WornPosition& position = task.rim.position;
  const LensPose pose = PoseOf(position.pantoscopic_tilt, position.face_form_angle, position.vertex_distance, task.eye);
  const LensOrder prescribed{PrescribedPower(task.order), PrescribedPrism(task.order, task.eye)};
  const Result<PowerMatrix> wanted =
      AtVertexDistance(prescribed.power, task.refracted_vertex, position.vertex_distance);
  if (!wanted) return Fail(wanted);
  const Result<PowerMatrix> at_cornea = AtVertexDistance(prescribed.power, task.refracted_vertex, 0.0);
  if (!at_cornea) return Fail(at_cornea);

  WornPowerReport& report = design.power;
  const Result<LensForm> plain = ThinnestLensForm(spec, prescribed, task.rim.outline, rule);
  if (!plain) return Fail(plain);
  const Result<TracedPower> plain_worn = TraceAsWorn(*plain, pose);
  if (!plain_worn) return Fail(plain_worn);
  CompensatedForm made{*plain, prescribed, 0.0};
  if (task.options.power_order != PowerOrder::kAsPrescribed) {
    const bool prism_too = task.options.power_order == PowerOrder::kCompensated;
    const WornGoal goal{{*wanted, prescribed.prism}, pose, prism_too ? PrismGoal::kAsWorn : PrismGoal::kAsOrdered};
    const Result<CompensatedForm> compensated = CompensatedLensForm(spec, goal, task.rim.outline, rule);
    if (!compensated) return Fail(compensated);
    made = *compensated;
  }
  const Result<TracedPower> worn = TraceAsWorn(made.form, pose);
  if (!worn) return Fail(worn);

  design.form = made.form;
  report.prescribed = PowerFrom(prescribed.power, prescribed.prism);
  report.wanted = PowerFrom(*wanted, prescribed.prism);
  report.at_cornea = PowerFrom(*at_cornea, prescribed.prism);
  report.tilt = TiltOf(pose.view_from_lens * design.form.optical_axis);
  report.martin = PowerFrom(MartinTilted(prescribed.power, spec.index, report.tilt), Eigen::Vector2d::Zero());
  report.uncompensated = PowerFrom(plain_worn->power, plain_worn->prism);
  report.to_surface = PowerFrom(made.order.power, made.order.prism);
  report.as_worn = PowerFrom(worn->power, worn->prism);
  report.uncompensated_error = WorstMeridian(plain_worn->power - *wanted);
  report.as_worn_error = WorstMeridian(worn->power - *wanted);
  report.uncompensated_prism_error = (plain_worn->prism - prescribed.prism).norm();
  report.as_worn_prism_error = (worn->prism - prescribed.prism).norm();
  report.within_tolerance = report.as_worn_error <= task.options.tolerance;
  report.uncompensated_within_tolerance = report.uncompensated_error <= task.options.tolerance;
  return {};
}

double RadiusOf(double curvature) {
  return curvature == 0.0 ? std::numeric_limits<double>::infinity() : 1.0 / curvature;
}

BlankReport BlankOf(const EyeTask& task, const LensDesign& design) {
  BlankReport blank;
  blank.minimum = design.box.ed + 2.0 * design.decentration.norm() + task.options.blank_allowance;
  double longest = 0.0;
  for (const Eigen::Vector2d& point : task.rim.outline.points) {
    longest = std::max(longest, (point - design.form.reference).norm());
  }
  blank.exact = 2.0 * longest + task.options.blank_allowance;
  for (const double stocked : task.options.stocked_blanks) {
    if (stocked >= blank.minimum - kBlankSlack && (!blank.stocked || stocked < *blank.stocked)) blank.stocked = stocked;
  }
  return blank;
}

/// Everything that follows from the surfaces.
void DescribeLens(const EyeTask& task, LensDesign& design) {
  const LensForm& form = design.form;
  design.front_radius = RadiusOf(form.front.curvature_u);
  if (std::isfinite(design.front_radius)) {
    design.front_centre = form.front.lens_from_surface.translation() - design.front_radius * Eigen::Vector3d::UnitZ();
  }
  design.back_radius_steep = RadiusOf(form.back.curvature_u);
  design.back_radius_flat = RadiusOf(form.back.curvature_v);
  design.edge = EdgeOf(form, task.rim.outline, kEdgePoints);
  design.body = BodyOf(form, task.rim.outline, task.material.density);
  design.thinnest = std::min(form.centre_thickness, design.edge.thinnest);
  design.thickest = std::max(form.centre_thickness, design.edge.thickest);
  if (const auto inner = InnerExtremeOf(form, task.rim.outline)) {
    design.thinnest = std::min(design.thinnest, inner->thickness);
    design.thickest = std::max(design.thickest, inner->thickness);
  }
  design.bevel = BevelOf(design.edge, design.box.centre, task.options.bevel);
  design.blank = BlankOf(task, design);
  design.add = task.order.add;
}

bool IsQuarterStep(double value) { return std::abs(value * 4.0 - std::round(value * 4.0)) < 1e-9; }

/// A power that no list of orders has: neither quarter dioptres nor eighths (0.12, 0.125, …).
bool IsUnusualStep(double value) {
  const double eighths = std::round(value * 8.0) / 8.0;
  return !IsQuarterStep(value) && std::abs(value - eighths) > 0.0051;
}

void RemarkOnOrder(const EyeTask& task, LensDesign& design) {
  if (IsUnusualStep(task.order.sphere) || IsUnusualStep(task.order.cylinder)) {
    Note(design, fmt::format("SPH {:+.3f} CYL {:+.3f} is no multiple of 1/8 D: check the order", task.order.sphere,
                             task.order.cylinder));
  }
  const double vogel = [&] {
    const double se = SphericalEquivalent(PrescribedPower(task.order));
    return se > 0.0 ? se + 6.0 : se / 2.0 + 6.0;
  }();
  if (task.options.base_rule == BaseCurveRule::kVogel && vogel != design.base) {
    Note(design, fmt::format("the base curve rule asks for {:+.2f} D; {:.2f} D is used", vogel, design.base));
  }
  if (!task.order.add) return;
  Note(design, fmt::format("ADD {:+.2f} D is carried on the order; surfaces, thickness and weight are those of the "
                           "single vision blank",
                           *task.order.add));
  constexpr double kBelowCorridor = 4.0;  // mm of near zone
  constexpr double kAbovePupil = 8.0;     // mm of distance zone
  if (design.fitting_height < task.options.corridor + kBelowCorridor) {
    Warn(design,
         fmt::format("the fitting height of {:.1f} mm is below the {:.1f} mm that a corridor of {:.1f} mm needs",
                     design.fitting_height, task.options.corridor + kBelowCorridor, task.options.corridor));
  }
  if (design.box.b - design.fitting_height < kAbovePupil) {
    Warn(design, fmt::format("only {:.1f} mm of lens are above the pupil; {:.1f} mm are needed for distance",
                             design.box.b - design.fitting_height, kAbovePupil));
  }
}

void RemarkOnLens(const EyeTask& task, LensDesign& design) {
  const WornPowerReport& power = design.power;
  if (!power.within_tolerance) {
    Warn(design, fmt::format("as worn the power is off by {:.2f} D, more than {:.2f} D: order the compensated power",
                             power.as_worn_error, task.options.tolerance));
  }
  const double half = task.options.bevel.width / 2.0;
  if (std::min(design.bevel.smallest_front, design.bevel.smallest_back) < half - 1e-9) {
    Warn(design, fmt::format("the bevel comes within {:.2f} mm of the front edge and {:.2f} mm of the back; {:.2f} mm "
                             "are needed: use a thicker edge or another bevel",
                             design.bevel.smallest_front, design.bevel.smallest_back, half));
  }
  if (!design.blank.stocked) {
    Warn(design,
         fmt::format("it needs a blank of {:.1f} mm and none is stocked (the exact way round the optical centre "
                     "is {:.1f} mm): use a smaller frame or order the blank",
                     design.blank.minimum, design.blank.exact));
  }
}

Result<LensDesign> DesignLens(const EyeTask& task) {
  LensDesign design;
  design.eye = task.eye;
  design.box = BoxOf(task.rim.outline);
  RETURN_IF_ERROR(PlaceOpticalCentre(task, design));
  design.base = BaseCurve(SphericalEquivalent(PrescribedPower(task.order)), task.options);
  if (const Status shaped = ShapeLens(task, design); !shaped) {
    Error error = shaped.error();
    error.seen = fmt::format("the {} lens: {}", EyeName(task.eye), error.seen);
    return tl::unexpected(error);
  }
  DescribeLens(task, design);
  RemarkOnOrder(task, design);
  RemarkOnLens(task, design);
  return design;
}

/// Remarks that concern both lenses.
void RemarkOnPair(const Prescription& prescription, LensPair& pair) {
  if (!prescription.centration_confirmed()) {
    pair.messages.push_back(
        {LensSeverity::kWarning, "PD and heights are an estimate, confirm by optician: no lab file without a name"});
  }
  const double strongest =
      std::max(WorstMeridian(PrescribedPower(prescription.right)), WorstMeridian(PrescribedPower(prescription.left)));
  if (!prescription.refracted_vertex) {
    const bool matters = strongest >= 4.0;
    pair.messages.push_back({matters ? LensSeverity::kWarning : LensSeverity::kNote,
                             fmt::format("the order does not say at which vertex distance it was refracted; {:.0f} mm "
                                         "is assumed{}",
                                         kUsualRefractedVertex, matters ? ": ask the prescriber" : "")});
  }
}

}  // namespace

double BaseCurve(double spherical_equivalent, const LensOptions& options) {
  if (options.base_rule == BaseCurveRule::kGiven) return options.given_base;
  const double rule = spherical_equivalent > 0.0 ? spherical_equivalent + 6.0 : spherical_equivalent / 2.0 + 6.0;
  if (options.base_rule == BaseCurveRule::kVogel) return std::clamp(rule, kFlattestBase, kSteepestBase);
  return *std::min_element(options.stocked_bases.begin(), options.stocked_bases.end(),
                           [rule](double a, double b) { return std::abs(a - rule) < std::abs(b - rule); });
}

Result<LensPair> DesignLensPair(const Prescription& prescription, const LensMaterial& material,
                                const FrameForLenses& frame, const LensOptions& options) {
  RETURN_IF_ERROR(Validate(prescription));
  RETURN_IF_ERROR(Validate(material));
  RETURN_IF_ERROR(ValidateOptions(options));
  RETURN_IF_ERROR(ValidateRim(frame.right, Eye::kRight));
  RETURN_IF_ERROR(ValidateRim(frame.left, Eye::kLeft));
  RETURN_IF_ERROR(InRange("DBL in mm", frame.dbl, 5.0, 40.0));

  const double vertex = prescription.refracted_vertex.value_or(kUsualRefractedVertex);
  const auto design = [&](Eye eye) {
    return DesignLens({eye, prescription.of(eye), frame.of(eye), material, options, vertex, frame.dbl});
  };
  const Result<LensDesign> right = design(Eye::kRight);
  if (!right) return Fail(right);
  const Result<LensDesign> left = design(Eye::kLeft);
  if (!left) return Fail(left);
  LensPair pair;
  pair.right = *right;
  pair.left = *left;
  pair.material = material;
  pair.position_right = frame.right.position;
  pair.position_left = frame.left.position;
  pair.dbl = frame.dbl;
  pair.centration_confirmed = prescription.centration_confirmed();
  pair.centration = pair.centration_confirmed ? "confirmed by " + prescription.centration_confirmed_by
                                              : "estimate, confirm by optician";
  RemarkOnPair(prescription, pair);
  return pair;
}

}  // namespace annulus
