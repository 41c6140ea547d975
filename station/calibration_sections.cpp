#include <fmt/format.h>

#include <algorithm>

#include "base/units.h"
#include "station/calibration_document.h"
#include "station/calibration_plots.h"

namespace annulus {
namespace {

using Align = SheetText::Align;
using Size = DocumentParagraph::Size;
using Grade = CalibrationFinding::Grade;

constexpr double kNormal95 = 1.959964;

/// Sensors that were held, which have no covariance: as ranges "0–14, 30".
std::string HeldSensors(const RingSolution& solution) {
  const auto& all = solution.sensor_covariance;
  std::string text;
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (!all[i].isZero()) continue;
    std::size_t end = i;
    while (end + 1 < all.size() && all[end + 1].isZero()) ++end;
    text += fmt::format("{}{}", text.empty() ? "" : ", ", i) + (end > i ? fmt::format("–{}", end) : "");
    i = end;
  }
  return text;
}

void AddSummary(const CalibrationReport& report, Document& document) {
  const RingSolution& solution = report.solution;
  std::size_t readings = 0;
  std::size_t rejected = 0;
  for (const PlacementResult& placement : solution.placements) {
    readings += placement.readings;
    rejected += placement.rejected;
  }
  document.blocks.emplace_back(DocumentHeading{"What was done"});
  std::string text = fmt::format(
      "{} placement{} of {} target{} were scanned; {} readings of the targets were used and {} wild ones left out. One "
      "return has a noise of {} mm. After the solve the residuals are {} times as large as noise alone explains "
      "(chi-square {} per degree of freedom).",
      solution.placements.size(), solution.placements.size() == 1 ? "" : "s", solution.targets.size(),
      solution.targets.size() == 1 ? "" : "s", readings, rejected, NumberWith(solution.noise_mm, 3),
      NumberWith(std::sqrt(std::max(0.0, solution.chi_square)), 2), NumberWith(solution.chi_square, 3));
  text += solution.quadratic ? " The range needed a term in the square of the reading."
                             : " The range needed no term in the square of the reading.";
  const bool step = std::any_of(report.targets.begin(), report.targets.end(), [](const ReportTarget& target) {
    return target.target.kind == CalibrationTarget::Kind::kStep;
  });
  if (!solution.height_scale) {
    text += " Heights keep the drive's own scale: no target had edges at known heights.";
  } else {
    text += step ? " Heights were measured by a step target."
                 : " The scale of heights rests on the targets' tilts; a step target would say more of it.";
  }
  document.blocks.emplace_back(DocumentParagraph{std::move(text)});
  const std::string held = HeldSensors(solution);
  if (!held.empty()) {
    document.blocks.emplace_back(DocumentParagraph{
        "Only some sensors were calibrated, against the ring around them. Left as they were: " + held + "."});
  }
}

DocumentCell GradeCell(Grade grade) {
  switch (grade) {
    case Grade::kFailure:
      return {"failure", DocumentMark::kBad};
    case Grade::kWarning:
      return {"warning", DocumentMark::kDoubtful};
    case Grade::kNote:
      break;
  }
  return {"note"};
}

void AddFindings(const RingSolution& solution, Document& document) {
  document.blocks.emplace_back(DocumentHeading{"Findings"});
  if (solution.findings.empty()) {
    document.blocks.emplace_back(DocumentParagraph{"The scans show nothing that needs attention."});
    return;
  }
  DocumentTable table;
  table.columns = {{"Grade", 1.0}, {"What was seen", 3.6}, {"What follows, and what to do", 4.4}, {"Code", 1.9}};
  for (const CalibrationFinding& finding : solution.findings) {
    table.rows.push_back(
        {GradeCell(finding.grade), Capital(finding.text) + ".", Capital(finding.advice) + ".", finding.code});
  }
  document.blocks.emplace_back(std::move(table));
}

/// The sensor that is furthest off, in words; "" if there is none.
std::string Furthest(const std::vector<double>& values, int decimals, const char* unit) {
  std::size_t at = values.size();
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (std::isfinite(values[i]) && (at == values.size() || std::abs(values[i]) > std::abs(values[at]))) at = i;
  }
  return at == values.size() ? "" : fmt::format("sensor {} by {}{}", at, SignedWith(values[at], decimals), unit);
}

void AddRangeErrors(const CalibrationReport& report, const SensorErrors& errors, Document& document) {
  document.blocks.emplace_back(DocumentHeading{"Radial errors around the ring"});
  std::string caption = "At 450 mm from each sensor; positive: a body is measured too large. ";
  caption += report.as_found ? "Before: the calibration that was in force, held against the new one. "
                             : "Before: the ring that the solve began with, held against the new calibration. ";
  caption +=
      "A shift of the ring's centre is taken out. After: each sensor's mean residual over all placements, with the 95 "
      "% "
      "uncertainty of its own radial error. Strips mark the boards, with the numbers of their sensors.";
  const std::string furthest = Furthest(errors.before_mm, 2, " mm");
  if (!furthest.empty()) caption += " Furthest off before: " + furthest + ".";
  document.blocks.emplace_back(
      DocumentFigure{DrawRangeErrors(errors, report.limits), std::move(caption), "radial_errors"});
  const Eigen::VectorXd& sigma = report.solution.common_sigma_mm;
  if (sigma.size() == 0) return;
  DocumentTable table;
  table.columns = {{"Distance from the sensor", 2.6}};
  std::vector<DocumentCell> row{"Error common to all sensors, 95 %"};
  for (Eigen::Index k = 0; k < sigma.size(); ++k) {
    table.columns.push_back(
        {fmt::format("{:g} mm", kCommonFrom + kCommonStep * static_cast<double>(k)), 1.0, Align::kRight});
    row.emplace_back("± " + NumberWith(kNormal95 * sigma[k], 3));
  }
  table.rows.push_back(std::move(row));
  document.blocks.emplace_back(std::move(table));
}

void AddAimErrors(const SensorErrors& errors, Document& document) {
  document.blocks.emplace_back(DocumentHeading{"Where the beams point"});
  std::string caption =
      "Errors before, of the place that a beam passes at 450 mm, as an angle there: positive sideways is the beam "
      "turned "
      "counter-clockwise seen from above, positive in height is the beam raised. A turn of the whole ring and a height "
      "common "
      "to all sensors are taken out. Bars and the lowest plot: what the new calibration leaves.";
  const std::string sideways = Furthest(errors.lateral_deg, 2, "°");
  const std::string height = Furthest(errors.vertical_deg, 2, "°");
  if (!sideways.empty() && !height.empty()) {
    caption += " Furthest off sideways: " + sideways + "; in height: " + height + ".";
  }
  document.blocks.emplace_back(DocumentFigure{DrawAimErrors(errors), std::move(caption), "aim_errors"});
}

DocumentTable Placements(const CalibrationReport& report) {
  DocumentTable table;
  table.columns = {{"Placement", 2.2},
                   {"Target", 1.5},
                   {"x, y / mm", 1.5, Align::kRight},
                   {"Tilt / °", 1.0, Align::kRight},
                   {"Turn / °", 1.05, Align::kRight},
                   {"Heights / mm", 1.6, Align::kRight},
                   {"RMS before / mm", 1.2, Align::kRight},
                   {"RMS after / mm", 1.15, Align::kRight},
                   {"Noise / mm", 1.0, Align::kRight},
                   {"Motion / mm", 1.15, Align::kRight},
                   {"its sd / mm", 1.0, Align::kRight}};
  for (const PlacementResult& p : report.solution.placements) {
    const std::string serial =
        p.target < report.targets.size() ? report.targets[p.target].target.serial : std::string();
    const double turn = std::round(DegreesFromRadians(p.pose.turn));
    table.rows.push_back({PlacementName(p.name), OrElse(serial, std::to_string(p.target + 1)),
                          fmt::format("{}, {}", NumberWith(p.pose.x, 0), NumberWith(p.pose.y, 0)),
                          NumberWith(DegreesFromRadians(p.tilt_rad), 1),
                          NumberWith(turn - 360.0 * std::floor(turn / 360.0), 0),
                          fmt::format("{}–{}", NumberWith(p.z_low_mm, 0), NumberWith(p.z_high_mm, 0)),
                          NumberWith(p.rms_before_mm, 3), NumberWith(p.rms_after_mm, 3), NumberWith(p.noise_mm, 3),
                          p.motion.seen ? NumberWith(p.motion.largest_mm, 3) : std::string("–"),
                          p.motion.seen ? NumberWith(p.motion.sigma_mm, 3) : std::string("–")});
  }
  return table;
}

void AddResiduals(const CalibrationReport& report, Document& document) {
  document.blocks.emplace_back(DocumentHeading{"Residuals"});
  document.blocks.emplace_back(DocumentFigure{
      DrawResidualMaps(report.solution),
      "Mean over all placements; red: the target is seen too large, blue: too small, grey: no target was seen. Before: "
      "with the "
      "calibration that the solve began with, every target at its best place. Columns are sensors by their direction.",
      "residual_maps"});
  std::vector<PlacementResidual> placements = PlacementResidualsOf(report.solution);
  for (PlacementResidual& placement : placements) placement.name = PlacementName(placement.name);
  document.blocks.emplace_back(DocumentHeading{"Placements"});
  document.blocks.emplace_back(DocumentFigure{DrawPlacementResiduals(placements),
                                              "Residuals of readings put together over 40 mm of height. A placement "
                                              "that stands out after the solve was disturbed, "
                                              "or its target is not what was entered.",
                                              "placement_residuals"});
  document.blocks.emplace_back(Placements(report));
  document.blocks.emplace_back(DocumentParagraph{
      "x, y: where the target's axis, a sphere's centre or a point of a board stood. Noise: standard deviation of one "
      "return. Motion: the largest distance, over all heights, between the places at which two sweeps saw the target; "
      "beside it, what noise alone gives one such distance.",
      Size::kNote});
}

}  // namespace

void AddSensorSections(const CalibrationReport& report, Document& document) {
  const SensorErrors errors = SensorErrorsOf(report);
  AddSummary(report, document);
  AddFindings(report.solution, document);
  AddRangeErrors(report, errors, document);
  AddAimErrors(errors, document);
  AddResiduals(report, document);
}

}  // namespace annulus
