#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <string_view>

#include "base/units.h"
#include "station/calibration_document.h"

namespace annulus {
namespace {

using Align = SheetText::Align;
using Verdict = LimitLine::Verdict;
using Size = DocumentParagraph::Size;

DocumentCell VerdictCell(Verdict verdict) {
  switch (verdict) {
    case Verdict::kPass:
      return {"pass", DocumentMark::kGood};
    case Verdict::kFail:
      return {"FAIL", DocumentMark::kBad};
    case Verdict::kNotChecked:
      break;
  }
  return {"–"};
}

/// The unit as it stands behind a number: degrees without a space.
std::string UnitText(const LimitLine& line) {
  return line.unit.empty() || line.unit == "°" ? line.unit : " " + line.unit;
}

std::string ValueText(const std::optional<double>& value, const LimitLine& line) {
  if (!value) return "–";
  const int decimals = line.limit == 0.0 ? 0 : line.unit.empty() ? 2 : 3;
  return NumberWith(*value, decimals) + UnitText(line);
}

std::string LimitText(const LimitLine& line) {
  if (line.limit == 0.0) return "none";
  return fmt::format("{:g}{}", line.limit, UnitText(line));
}

DocumentTable LimitTable(const std::vector<LimitLine>& lines) {
  DocumentTable table;
  table.columns = {{"", 5.2},
                   {"As found", 1.7, Align::kRight},
                   {"", 0.9, Align::kCentre},
                   {"As left", 1.7, Align::kRight},
                   {"", 0.9, Align::kCentre},
                   {"Limit", 1.4, Align::kRight}};
  for (const LimitLine& line : lines) {
    table.rows.push_back({line.name, ValueText(line.found, line), VerdictCell(line.found_verdict()),
                          line.left ? ValueText(line.left, line) : std::string("not checked"),
                          VerdictCell(line.left_verdict()), LimitText(line)});
  }
  return table;
}

DocumentNotice VerdictNotice(const CalibrationReport& report, const std::vector<LimitLine>& lines) {
  std::string failed;
  for (const LimitLine& line : lines) {
    if (line.left_verdict() == Verdict::kFail) failed += (failed.empty() ? "" : "; ") + line.name;
  }
  if (!failed.empty()) {
    return {"FAIL", "Outside the limits as left: " + failed + ". The ring must not be used with this calibration.",
            DocumentMark::kBad};
  }
  if (!report.verification) {
    return {"PASS, NOT VERIFIED",
            "All that was checked is within its limits as left, but no second artefact was measured: a wrong radius of "
            "the targets would not show.",
            DocumentMark::kDoubtful};
  }
  return {"PASS", "All is within its limits as left, and a second artefact confirms it.", DocumentMark::kGood};
}

DocumentNotice TraceabilityNotice(const CalibrationReport& report) {
  const Traceability traceability = TraceabilityOf(report);
  if (traceability.traceable) return {"Traceable", Capital(traceability.statement) + ".", DocumentMark::kGood};
  return {Capital(traceability.statement),
          "Lengths that are measured with this calibration cannot be referred to the metre through it.",
          DocumentMark::kBad};
}

DocumentTable Facts(const CalibrationReport& report) {
  const std::string ambient = report.ambient_c ? NumberWith(*report.ambient_c, 1) + " °C" : std::string("not entered");
  DocumentTable table;
  table.columns = {{"", 1.25}, {"", 2.6}, {"", 1.15}, {"", 2.4}};
  table.rows = {
      {"Ring", OrElse(report.ring_serial, "serial not entered"), "Date", OrElse(report.date, "not entered")},
      {"Technician", OrElse(report.technician, "not entered"), "Valid for", OrElse(report.valid_for, "not entered")},
      {"Room", ambient, "Next due", OrElse(report.next_due, "not entered")},
      {"Calibration", ShortHash(report.calibration_hash), "Program",
       "annulus " + OrElse(report.program_version, "(version not known)")}};
  if (report.as_found) {
    const AsFound& found = *report.as_found;
    table.rows.push_back({"In force before", OrElse(ShortHash(found.calibration_hash), "an ideal ring"), "Its date",
                          OrElse(found.date, "not known")});
  } else {
    table.rows.push_back({"In force before", "nothing that is known of", "", ""});
  }
  return table;
}

DocumentTable Targets(const CalibrationReport& report) {
  DocumentTable table;
  table.columns = {{"Target", 1.9},
                   {"Certificate", 1.9},
                   {"Certified radius (k = 2)", 2.3, Align::kRight},
                   {"at", 0.8, Align::kRight},
                   {"Scanned at", 1.0, Align::kRight},
                   {"Radius there", 1.3, Align::kRight}};
  const auto add = [&](std::string name, const CalibrationTarget& target, double temperature_c) {
    const bool plane = target.kind == CalibrationTarget::Kind::kPlane;
    DocumentCell certificate = target.certificate_number;
    if (target.certificate_number.empty()) certificate = {"none", DocumentMark::kBad};
    table.rows.push_back({std::move(name), certificate,
                          plane ? std::string("–") : RadiusText(target.radius_mm, target.expanded_u_mm),
                          NumberWith(target.certified_c, 1) + " °C", NumberWith(temperature_c, 1) + " °C",
                          plane ? std::string("–") : NumberWith(target.RadiusAt(temperature_c), 3) + " mm"});
  };
  for (std::size_t t = 0; t < report.targets.size(); ++t) {
    const CalibrationTarget& target = report.targets[t].target;
    const std::string serial = target.serial.empty() ? "" : " " + target.serial;
    add(Capital(KindName(target.kind)) + serial, target, report.targets[t].temperature_c);
  }
  if (report.verification) {
    const CalibrationTarget& target = report.verification->target;
    add("Second artefact: " + KindName(target.kind) + (target.serial.empty() ? "" : " " + target.serial), target,
        report.verification->temperature_c);
  }
  return table;
}

}  // namespace

std::string NumberWith(double value, int decimals) {
  if (!std::isfinite(value)) return "–";
  const double unit = std::pow(10.0, -decimals);
  // + 0.0: no "-0.00"
  return fmt::format("{:.{}f}", std::abs(value) < 0.5 * unit ? 0.0 : value, decimals);
}

std::string SignedWith(double value, int decimals) {
  const std::string text = NumberWith(value, decimals);
  return std::isfinite(value) && value >= 0.5 * std::pow(10.0, -decimals) ? "+" + text : text;
}

std::string OrElse(const std::string& text, const std::string& otherwise) { return text.empty() ? otherwise : text; }

std::string Capital(std::string text) {
  if (!text.empty()) text.front() = static_cast<char>(std::toupper(static_cast<unsigned char>(text.front())));
  return text;
}

std::string ShortHash(const std::string& hash) {
  constexpr std::size_t kEnough = 23;
  return hash.size() > kEnough ? hash.substr(0, kEnough) + "…" : hash;
}

std::string RadiusText(double radius_mm, double expanded_u_mm) {
  return fmt::format("{} ± {} mm", NumberWith(radius_mm, 3), NumberWith(expanded_u_mm, 3));
}

std::string PlacementName(const std::string& name) {
  const std::size_t slash = name.rfind('/');
  std::string file = slash == std::string::npos ? name : name.substr(slash + 1);
  constexpr std::string_view kEnding = ".mcap";
  if (file.size() > kEnding.size() && file.ends_with(kEnding)) file.resize(file.size() - kEnding.size());
  return file;
}

std::string KindName(CalibrationTarget::Kind kind) {
  switch (kind) {
    case CalibrationTarget::Kind::kCylinder:
      return "column";
    case CalibrationTarget::Kind::kSphere:
      return "sphere";
    case CalibrationTarget::Kind::kPlane:
      return "flat board";
    case CalibrationTarget::Kind::kStep:
      return "step column";
  }
  return "target";
}

void AddCertificate(const CalibrationReport& report, Document& document) {
  auto& blocks = document.blocks;
  const std::vector<LimitLine> lines = JudgeCalibration(report);
  blocks.emplace_back(VerdictNotice(report, lines));
  blocks.emplace_back(TraceabilityNotice(report));
  blocks.emplace_back(Facts(report));
  blocks.emplace_back(DocumentHeading{"Targets"});
  blocks.emplace_back(Targets(report));
  blocks.emplace_back(DocumentHeading{"As found and as left"});
  blocks.emplace_back(LimitTable(lines));
  std::string note = report.as_found
                         ? "As found: the calibration that was in force, held against the new one. "
                         : "As found: the ring had no calibration before, so there is nothing to hold against. ";
  note +=
      "As left: what the new calibration leaves uncertain. No calibration knows radii better than its targets: U of "
      "their certificates is the floor of the error common to all sensors.";
  blocks.emplace_back(DocumentParagraph{std::move(note), Size::kNote});
  blocks.emplace_back(DocumentSignature{{"Technician: " + OrElse(report.technician, "(name)"), "Date and signature"}});
  blocks.emplace_back(DocumentPageBreak{});
}

Document CalibrationDocument(const CalibrationReport& report) {
  Document document;
  document.title = "Ring calibration: certificate and report";
  document.footer =
      fmt::format("annulus {} · ring {} · {} · {}", OrElse(report.program_version, "–"),
                  OrElse(report.ring_serial, "–"), OrElse(report.date, "–"), OrElse(report.calibration_hash, "–"));
  AddCertificate(report, document);
  AddSensorSections(report, document);
  AddKnowledgeSections(report, document);
  return document;
}

}  // namespace annulus
