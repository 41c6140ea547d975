#include <fmt/format.h>

#include <algorithm>

#include "base/units.h"
#include "station/calibration_document.h"
#include "station/calibration_plots.h"

namespace annulus {
namespace {

using Align = SheetText::Align;
using Size = DocumentParagraph::Size;

constexpr double kNormal95 = 1.959964;

void AddCarriage(const RingSolution& solution, Document& document) {
  document.blocks.emplace_back(DocumentHeading{"The carriage's way"});
  const RingPose& pose = solution.calibration.pose;
  std::string caption = fmt::format(
      "x is the subject's right, y the front. The ring's plane is tilted by {}° about x and {}° about y. How far the "
      "straight "
      "line leans against the vertical cannot be seen with targets whose own tilt is not known. ",
      SignedWith(DegreesFromRadians(pose.tilt_x), 3), SignedWith(DegreesFromRadians(pose.tilt_y), 3));
  caption +=
      "Outside the heights where a target stood nothing is known of the way: it is taken to stay where it was last "
      "seen.";
  document.blocks.emplace_back(DocumentFigure{DrawStraightness(solution), std::move(caption), "straightness"});
}

DocumentTable TargetTable(const CalibrationReport& report) {
  DocumentTable table;
  table.columns = {{"Target", 2.2},
                   {"Certified radius / mm", 1.9, Align::kRight},
                   {"U (k = 2) / mm", 1.1, Align::kRight},
                   {"Radius found / mm", 1.6, Align::kRight},
                   {"The others say / mm", 2.0, Align::kRight},
                   {"Taper / mm per m", 1.4, Align::kRight},
                   {"Out of round / mm", 1.5, Align::kRight}};
  for (std::size_t t = 0; t < report.solution.targets.size(); ++t) {
    const TargetResult& target = report.solution.targets[t];
    const bool plane = t < report.targets.size() && report.targets[t].target.kind == CalibrationTarget::Kind::kPlane;
    const std::string name = Capital(TargetName(report, t));
    if (plane) {
      table.rows.push_back({name, "–", "–", "–", "–", "–", "–"});
      continue;
    }
    const bool said = std::isfinite(target.radius_miss_mm) && target.radius_miss_sigma_mm > 0.0;
    table.rows.push_back({name, NumberWith(target.certified_radius_mm, 3),
                          NumberWith(2.0 * target.certified_sigma_mm, 3), NumberWith(target.form.radius_mm, 3),
                          said ? fmt::format("{} ± {}", SignedWith(target.radius_miss_mm, 3),
                                             NumberWith(kNormal95 * target.radius_miss_sigma_mm, 3))
                               : std::string("nothing"),
                          SignedWith(1000.0 * target.form.taper, 2), NumberWith(target.out_of_round_mm, 3)});
  }
  return table;
}

void AddTargets(const CalibrationReport& report, Document& document) {
  document.blocks.emplace_back(DocumentHeading{"Shapes of the targets"});
  const auto& targets = report.solution.targets;
  if (std::any_of(targets.begin(), targets.end(), HasRoundness)) {
    std::vector<std::string> names;
    for (std::size_t t = 0; t < targets.size(); ++t) {
      names.push_back(Capital(TargetName(report, t)));
    }
    document.blocks.emplace_back(DocumentFigure{DrawRoundness(report.solution, names),
                                                "Deviations from a circle by the target's own angle, enlarged, with "
                                                "their 95 % band. They were told apart from the "
                                                "sensors' errors because the target was turned between placements.",
                                                "roundness"});
  }
  document.blocks.emplace_back(TargetTable(report));
  document.blocks.emplace_back(
      DocumentParagraph{"Radii are at the temperature of the scans. \"The others say\": what all other readings make "
                        "of a radius, less its "
                        "certificate, ± 95 %; more than that apart, one of the radii is not what was entered.",
                        Size::kNote});
}

/// A quantity in the unit in which a technician reads it.
struct ShownUnit {
  double factor = 1.0;
  std::string unit;
};

ShownUnit UnitOf(const std::string& unit) {
  constexpr double kPerMetre = 1000.0;
  if (unit == "rad") return {DegreesFromRadians(1.0), "°"};
  if (unit == "rad/mm") return {kPerMetre * DegreesFromRadians(1.0), "° per m"};
  if (unit == "mm/mm") return {kPerMetre, "mm per m"};
  if (unit == "mm per (100 mm)^2") return {1.0, "mm per (100 mm)²"};
  if (unit == "mm per degree") return {1.0, "mm per °C"};
  return {1.0, unit};
}

void AddObservability(const RingSolution& solution, Document& document) {
  document.blocks.emplace_back(DocumentHeading{"What is known and what is not"});
  document.blocks.emplace_back(
      DocumentParagraph{"Each quantity's standard deviation from the tolerances alone, and with the readings. Where "
                        "the readings add nothing of use, "
                        "the quantity is not known: it keeps its value from before, and nothing was invented."});
  DocumentTable table;
  table.columns = {{"Quantity", 2.9},
                   {"Known", 0.9, Align::kCentre},
                   {"Tolerance alone", 1.2, Align::kRight},
                   {"With readings", 1.1, Align::kRight},
                   {"Unit", 2.1},
                   {"What follows", 4.3}};
  for (const Observability& entry : solution.observability) {
    const ShownUnit shown = UnitOf(entry.unit);
    table.rows.push_back(
        {Capital(entry.name),
         entry.observable ? DocumentCell("yes", DocumentMark::kGood) : DocumentCell("no", DocumentMark::kDoubtful),
         fmt::format("{:.3g}", shown.factor * entry.prior_sd), fmt::format("{:.3g}", shown.factor * entry.posterior_sd),
         shown.unit, entry.consequence});
  }
  document.blocks.emplace_back(std::move(table));
  document.blocks.emplace_back(
      DocumentParagraph{"Also not known, whatever the targets: the carriage's way outside the heights where a target "
                        "stood, and the ring's height "
                        "over the floor, which is homing's.",
                        Size::kNote});
}

/// What the targets' certificates alone leave in a girth, 95 %: the budget's first line; in words.
std::string FloorText(const CalibrationReport& report) {
  double largest_u = 0.0;
  for (const ReportTarget& target : report.targets) {
    if (target.target.kind != CalibrationTarget::Kind::kPlane)
      largest_u = std::max(largest_u, target.target.expanded_u_mm);
  }
  std::string text =
      "U of the targets' certificates is the floor of the error common to all sensors: no number of scans brings it "
      "down.";
  if (largest_u > 0.0) {
    text += fmt::format(
        " A radius that is wrong by U = {} mm (k = 2) is {} mm of every girth (2π·U) and {} % of volume under a girth "
        "of 900 mm.",
        NumberWith(largest_u, 3), NumberWith(kTwoPi * largest_u, 2),
        NumberWith(200.0 * largest_u / (900.0 / kTwoPi), 3));
  } else {
    text += " No uncertainty was entered for the targets, so the budget's line for them says too little.";
  }
  return text;
}

/// What the certificate holds against the limit of a girth, mm.
std::optional<double> GirthHalf95(const CalibrationReport& report) {
  for (const LimitLine& line : JudgeCalibration(report)) {
    if (line.name.starts_with("Girth")) return line.left;
  }
  return std::nullopt;
}

void AddBudget(const CalibrationReport& report, Document& document) {
  document.blocks.emplace_back(DocumentHeading{"Error budget"});
  document.blocks.emplace_back(DocumentParagraph{FloorText(report)});
  std::vector<BudgetLine> budget = report.solution.budget;
  for (BudgetLine& line : budget) line.name = Capital(line.name);
  std::vector<BudgetLine> shown = budget;
  std::string caption =
      "What each part leaves in a girth of 900 mm around the ring's centre; the last bar is all of them together.";
  if (const auto held = GirthHalf95(report); held && !shown.empty()) {
    shown.insert(shown.end() - 1, {"At the temperature it had", *held / kNormal95, 0.0});
    caption += fmt::format(
        " The limit is held against ± {} mm: all but the ring being warmer or colder than it was while it was "
        "calibrated.",
        NumberWith(*held, 3));
  }
  document.blocks.emplace_back(DocumentFigure{DrawBudget(shown, report.limits.girth_mm), std::move(caption), "budget"});
  DocumentTable table;
  table.columns = {{"Part", 3.6},
                   {"Girth of 900 mm, sd / mm", 2.2, Align::kRight},
                   {"95 % / mm", 1.3, Align::kRight},
                   {"Volume, sd / %", 1.4, Align::kRight},
                   {"95 % / %", 1.2, Align::kRight}};
  table.last_row = DocumentTable::LastRow::kTotal;
  for (const BudgetLine& line : budget) {
    table.rows.push_back({line.name, NumberWith(line.girth_mm, 3), NumberWith(kNormal95 * line.girth_mm, 3),
                          NumberWith(line.volume_percent, 4), NumberWith(kNormal95 * line.volume_percent, 4)});
  }
  document.blocks.emplace_back(std::move(table));
}

void AddVerification(const CalibrationReport& report, Document& document) {
  document.blocks.emplace_back(DocumentHeading{"Verification on a second artefact"});
  if (!report.verification) {
    document.blocks.emplace_back(
        DocumentNotice{"Not verified",
                       "No artefact that took no part in the solve was measured. A wrong radius of the "
                       "targets would go into all girths unseen: 0.1 mm is 0.6 mm of girth.",
                       DocumentMark::kDoubtful});
    return;
  }
  const CalibrationVerification& seen = *report.verification;
  const CalibrationTarget& target = seen.target;
  DocumentTable table;
  table.columns = {{"", 3.0}, {"", 5.0}};
  table.rows = {{"Artefact", Capital(KindName(target.kind)) + (target.serial.empty() ? "" : " " + target.serial)},
                {"Certificate", target.certificate_number.empty() ? DocumentCell("none", DocumentMark::kBad)
                                                                  : DocumentCell(target.certificate_number)},
                {"Scanned at", NumberWith(seen.temperature_c, 1) + " °C"},
                {"Certified radius there (k = 2)", RadiusText(seen.certified_radius_mm, seen.certified_u_mm)},
                {"Radius found (k = 2)", RadiusText(seen.found_radius_mm, seen.found_u_mm)},
                {"Found less certified", SignedWith(seen.found_radius_mm - seen.certified_radius_mm, 3) + " mm"},
                {"En", DocumentCell(NumberWith(seen.En(), 2) +
                                        (std::abs(seen.En()) <= 1.0 ? ": they agree" : ": they do NOT agree"),
                                    std::abs(seen.En()) <= 1.0 ? DocumentMark::kGood : DocumentMark::kBad)},
                {"Residuals of the sensors, RMS", NumberWith(seen.residual_rms_mm, 3) + " mm"}};
  document.blocks.emplace_back(std::move(table));
  if (!seen.sensor_residual_mm.empty()) {
    document.blocks.emplace_back(
        DocumentFigure{DrawVerification(seen.sensor_residual_mm, report.limits),
                       "Each sensor's mean residual on the second artefact; positive: it is seen too large. A slow "
                       "wave around the ring is the artefact's own out-of-roundness.",
                       "verification"});
  }
}

void AddLimits(const CalibrationReport& report, Document& document) {
  document.blocks.emplace_back(DocumentHeading{"How the lines of the certificate are found"});
  DocumentTable table;
  table.columns = {{"Line", 3.2}, {"How it is found", 6.2}};
  for (const LimitLine& line : JudgeCalibration(report)) table.rows.push_back({line.name, line.meaning});
  document.blocks.emplace_back(std::move(table));
}

void AddHistory(const CalibrationReport& report, Document& document) {
  document.blocks.emplace_back(DocumentHeading{"Calibrations of this ring"});
  DocumentTable table;
  table.columns = {{"Date", 2.9},
                   {"Calibration", 2.6},
                   {"Technician", 2.0},
                   {"Off when replaced / mm", 1.7, Align::kRight},
                   {"", 1.0, Align::kCentre}};
  const auto verdict = [](bool passed) {
    return passed ? DocumentCell("pass", DocumentMark::kGood) : DocumentCell("FAIL", DocumentMark::kBad);
  };
  for (const EarlierCalibration& earlier : report.history) {
    table.rows.push_back({OrElse(earlier.date, "–"), ShortHash(earlier.hash), OrElse(earlier.technician, "–"),
                          SignedWith(earlier.common_mm, 3), verdict(earlier.passed)});
  }
  table.rows.push_back({OrElse(report.date, "–") + " (this one)", ShortHash(report.calibration_hash),
                        OrElse(report.technician, "–"), "–", verdict(CalibrationPasses(report))});
  document.blocks.emplace_back(std::move(table));
  document.blocks.emplace_back(DocumentParagraph{
      "Off when replaced: the radial error common to all sensors that a calibration had by then; positive: bodies were "
      "measured too large.",
      Size::kNote});
}

}  // namespace

void AddKnowledgeSections(const CalibrationReport& report, Document& document) {
  AddCarriage(report.solution, document);
  AddTargets(report, document);
  AddObservability(report.solution, document);
  AddBudget(report, document);
  AddVerification(report, document);
  AddLimits(report, document);
  AddHistory(report, document);
}

}  // namespace annulus
