#include "station/report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "base/markup_text.h"
#include "modeling/exchange/base64.h"
#include "station/command_line.h"
#include "station/measurement_output.h"

namespace annulus {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kStyleSheet = R"css(
:root { color-scheme: light dark; --page:#f6f7f8; --card:#ffffff; --text:#1d2430; --soft:#5b6675; --line:#dde2e8;
  --accent:#0f5f74; --good:#1a7f4b; }
@media (prefers-color-scheme: dark) { :root { --page:#14181d; --card:#1c2229; --text:#e6eaef; --soft:#98a3b1;
  --line:#303945; --accent:#6cc3d8; --good:#5fd094; } }
* { box-sizing: border-box; }
body { margin:0; background:var(--page); color:var(--text); font:16px/1.5 system-ui, "Segoe UI", "DejaVu Sans", sans-serif; }
main { max-width:1120px; margin:0 auto; padding:2.5rem 1.5rem 4rem; }
h1 { font-size:2rem; margin:0 0 .25rem; letter-spacing:-.01em; }
h2 { font-size:1.5rem; margin:3rem 0 1rem; padding-top:1.5rem; border-top:2px solid var(--accent); }
h3 { font-size:1.05rem; margin:2rem 0 .6rem; }
p { max-width:46rem; } .soft { color:var(--soft); }
.cards { display:grid; grid-template-columns:repeat(auto-fit, minmax(15rem, 1fr)); gap:1rem; margin:1.5rem 0; }
.card { background:var(--card); border:1px solid var(--line); border-radius:.5rem; padding:1rem 1.2rem; }
.card b { display:block; font-size:1.6rem; font-weight:600; color:var(--good); font-variant-numeric:tabular-nums; }
.card span { color:var(--soft); font-size:.9rem; }
table { border-collapse:collapse; width:100%; background:var(--card); border:1px solid var(--line); font-size:.93rem; }
th, td { padding:.38rem .8rem; text-align:right; border-bottom:1px solid var(--line); font-variant-numeric:tabular-nums; }
th { color:var(--soft); font-weight:600; } th:first-child, td:first-child { text-align:left; }
tr.group td { background:var(--page); color:var(--soft); font-weight:600; }
tr:last-child td { border-bottom:0; } table.facts td:last-child { text-align:left; width:70%; }
.scroll { overflow-x:auto; }
.pictures { display:grid; gap:1rem; grid-template-columns:repeat(auto-fit, minmax(15rem, 21rem)); align-items:start; }
figure { margin:0; background:var(--card); border:1px solid var(--line); border-radius:.5rem; overflow:hidden; }
figure img { display:block; width:100%; height:auto; }
figcaption { padding:.5rem .8rem; font-size:.88rem; color:var(--soft); }
ul { padding-left:1.2rem; } li { margin:.2rem 0; } code { font-size:.92em; }
)css";

/// Digits that are worth showing: hundredths of a mm, of a dm³ more.
std::string Shown(double value, const std::string& unit) {
  return std::isfinite(value) ? fmt::format(fmt::runtime(unit == "dm³" ? "{:.3f}" : "{:.2f}"), value)
                              : std::string("–");
}

std::string ShownDifference(const TruthComparison& row) {
  const double unit = row.unit == "dm³" ? 1e-3 : 1e-2;
  const double rounded = std::round((row.measured - row.truth) / unit) * unit + 0.0;  // + 0.0: no "-0.00"
  return fmt::format(fmt::runtime(row.unit == "dm³" ? "{:+.3f}" : "{:+.2f}"), rounded);
}

std::string Fact(const std::string& name, const std::string& value) {
  return "<tr><td>" + MarkupText(name) + "</td><td>" + MarkupText(value) + "</td></tr>\n";
}

std::string ComparisonTable(const std::vector<TruthComparison>& comparisons) {
  std::string html =
      "<div class=\"scroll\"><table><thead><tr><th>Quantity</th><th>Unit</th><th>Measured</th><th>± 95 %</th>"
      "<th>True</th><th>Difference</th></tr></thead><tbody>\n";
  const TruthComparison* before = nullptr;
  for (const TruthComparison& row : comparisons) {
    if (before == nullptr || before->group != row.group) {
      html += fmt::format("<tr class=\"group\"><td colspan=\"6\">{}</td></tr>\n", ComparisonGroupName(row.group));
    }
    before = &row;
    html += fmt::format("<tr><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td></tr>\n",
                        MarkupText(row.term), row.unit, Shown(row.measured, row.unit), Shown(row.half95, row.unit),
                        Shown(row.truth, row.unit), ShownDifference(row));
  }
  return html + "</tbody></table></div>\n";
}

std::string MeasurementTableHtml(const MeasurementTable& table) {
  std::string html =
      "<div class=\"scroll\"><table><thead><tr><th>Measurement</th><th>Value</th><th>95 % interval</th>"
      "<th>Seen</th><th>Interval within class limit</th></tr></thead><tbody>\n";
  for (const Measurement& m : table.measurements) {
    const double half = HalfWidth95(m.value);
    const auto within = IntervalWithinLimit(m);
    html += fmt::format(
        "<tr><td>{}</td><td>{:.1f} {}</td><td>{}</td><td>{:.0f} %</td><td>{}</td></tr>\n", MarkupText(m.term),
        m.value.value, m.unit,
        std::isfinite(half) ? fmt::format("{:.1f} … {:.1f}", m.value.value - half, m.value.value + half) : "–",
        100.0 * m.measured_share,
        within ? fmt::format("{} ({:g} mm)", *within ? "yes" : "no", m.iso20685_limit_mm) : std::string("–"));
  }
  return html + "</tbody></table></div>\n";
}

std::string Pictures(const std::vector<DemoPicture>& pictures) {
  std::string html = "<div class=\"pictures\">\n";
  for (const DemoPicture& picture : pictures) {
    html += fmt::format(
        "<figure><img alt=\"{0}\" src=\"data:image/png;base64,{1}\"><figcaption>{0}</figcaption>"
        "</figure>\n",
        MarkupText(picture.caption), EncodeBase64(picture.png));
  }
  return html + "</div>\n";
}

std::string ScanAndFit(const DemoSubject& subject) {
  const ScanSummary& scan = subject.scan.summary;
  const FitSummary& fit = subject.fit;
  const auto outliers = static_cast<std::size_t>(
      std::count_if(fit.rejected.begin(), fit.rejected.end(),
                    [](const RejectedSample& sample) { return sample.reason == SampleVerdict::kOutlier; }));
  std::string html = "<div class=\"scroll\"><table class=\"facts\"><tbody>\n";
  html += Fact("Scan",
               fmt::format("{} levels in {} sweep{}, {:.1f} s of booth time", scan.levels, scan.sweeps,
                           scan.sweeps == 1 ? "" : "s", std::chrono::duration<double>(scan.end - scan.start).count()));
  html += Fact("Returns", fmt::format("{} ranges, {} readings without a return, {} frames lost", scan.returns,
                                      scan.no_returns, scan.ring.lost_frames));
  for (const std::string& reason : subject.scan.adjusted) html += Fact("Plan adjusted", reason);
  html += Fact("Surface", fmt::format("{} coefficients, {:.0f} effective parameters, {}", fit.coefficients,
                                      fit.effective_parameters, fit.termination));
  html += Fact("Noise of a return",
               fmt::format("{:.2f} mm (1 sd), residual RMS {:.2f} mm", fit.noise_sigma_mm, fit.rms_mm));
  html += Fact("Left out of the fit",
               fmt::format("{} outliers, {} returns of things in front of the body or too small to fit", outliers,
                           fit.rejected.size() - outliers));
  return html + "</tbody></table></div>\n";
}

std::string Inferred(const DemoSubject& subject) {
  std::string html = fmt::format(
      "<ul><li>Of the surface between the lowest and the highest return, {:.1f} % was seen, {:.1f} % is inferred "
      "between returns, and {:.1f} % is unknown: no number is given there.</li>\n",
      100.0 * subject.shares.measured, 100.0 * subject.shares.inferred, 100.0 * subject.shares.unknown);
  for (const SectionRegion& region : subject.fit.regions) {
    html += "<li>Not one loop around the axis: " + MarkupText(region.BriefReport()) + ".</li>\n";
  }
  for (const Measurement& m : subject.table.measurements) {
    if (m.measured_share < 0.999 && m.id.ends_with("_girth")) {
      html +=
          fmt::format("<li>{}: {:.0f} % of the outline was seen.</li>\n", MarkupText(m.term), 100.0 * m.measured_share);
    }
  }
  for (const std::string& sentence : subject.table.omitted) html += "<li>" + MarkupText(sentence) + "</li>\n";
  return html + "</ul>\n";
}

std::string Glasses(const DemoGlasses& glasses) {
  const WornFrame& worn = glasses.fit.worn;
  std::string html = "<h3>Glasses</h3>\n<div class=\"scroll\"><table class=\"facts\"><tbody>\n";
  html += Fact("Style", glasses.style);
  html += Fact("Made to measure", fmt::format("rims {:.1f} mm wide and {:.1f} mm high on their centre line",
                                              worn.design.parameters.width, worn.design.parameters.height));
  for (const FitGoal& goal : glasses.fit.goals) {
    const char* degrees = goal.unit == "deg" ? "°" : goal.unit == "%" ? " %" : " mm";
    html += Fact(goal.term, fmt::format("{:.1f}{}, usual {:.1f} to {:.1f}{}", goal.value, degrees, goal.low, goal.high,
                                        goal.met ? "" : ": not met"));
  }
  for (const FrameContact& contact : glasses.fit.contacts) {
    html += Fact("Rests on", fmt::format("{}, {:.0f} % of the weight", contact.part, 100.0 * contact.load_share));
  }
  for (const std::string& sentence : glasses.fit.advice) html += Fact("To change", sentence);
  for (const LandmarkSource source : {LandmarkSource::kDetected, LandmarkSource::kProportion}) {
    std::string names;
    for (const NamedFacePoint& named : FacePointNames()) {
      if ((worn.face.*named.member).source != source) continue;
      std::string name(named.name);
      std::replace(name.begin(), name.end(), '_', ' ');
      names += (names.empty() ? "" : ", ") + name;
    }
    if (names.empty()) continue;
    html += Fact(source == LandmarkSource::kDetected ? "Found on the surface" : "Placed by proportion", names);
  }
  return html + "</tbody></table></div>\n";
}

std::string Files(const DemoSubject& subject) {
  std::string html = "<div class=\"scroll\"><table class=\"facts\"><tbody>\n";
  for (const DemoFile& file : subject.files) html += Fact(file.name, file.purpose);
  return html + "</tbody></table></div>\n";
}

std::string SubjectHtml(const DemoSubject& subject) {
  // The pictures of the shape come first, the diagrams where they are talked about.
  std::vector<DemoPicture> portraits;
  std::vector<DemoPicture> diagrams;
  for (const DemoPicture& picture : subject.pictures) {
    const bool diagram =
        picture.file.find("_section_") != std::string::npos || picture.file.find("_residuals") != std::string::npos;
    (diagram ? diagrams : portraits).push_back(picture);
  }
  std::string html = "<h2>" + MarkupText(subject.title) + "</h2>\n" + Pictures(portraits);
  html += "<h3>Measured against true</h3>\n" + ComparisonTable(subject.comparisons);
  html += "<h3>Measurement table</h3>\n" + MeasurementTableHtml(subject.table);
  if (subject.glasses) html += Glasses(*subject.glasses);
  html += "<h3>Scan and fit</h3>\n" + ScanAndFit(subject);
  html += "<h3>What was not seen</h3>\n" + Inferred(subject);
  html += "<h3>Surface against returns and truth</h3>\n" + Pictures(diagrams);
  return html + "<h3>Files</h3>\n" + Files(subject);
}

std::string Card(const std::string& value, const std::string& meaning) {
  return "<div class=\"card\"><b>" + value + "</b><span>" + MarkupText(meaning) + "</span></div>\n";
}

std::string Cards(const DemoResult& result) {
  std::string html = "<div class=\"cards\">\n";
  for (const DemoSubject& subject : result.subjects) {
    html += Card(fmt::format("{:.2f} mm", LargestGirthError(subject.comparisons)),
                 subject.title + ": largest difference of a girth from its true value");
    html += Card(fmt::format("{:.3f} %", 100.0 * LargestVolumeError(subject.comparisons)),
                 subject.title + ": difference of the volume from its true value");
  }
  return html + "</div>\n";
}

}  // namespace

std::string RenderReport(const DemoResult& result) {
  std::string html =
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
      "<title>annulus demo</title>\n<style>";
  html += kStyleSheet;
  html += "</style>\n</head>\n<body>\n<main>\n<h1>From scan to glasses</h1>\n";
  html += fmt::format("<p class=\"soft\">annulus {}, simulated booth, seed {}</p>\n", ProgramVersion(), result.seed);
  html +=
      "<p>A ring of 180 range sensors travelled over a subject whose true measures are known. Each sensor has a noise "
      "of "
      "0.5 mm, and some of its readings are missing or wrong. One smooth surface was fitted to the recording; every "
      "number and picture below comes from that surface. Girths are taken as a tape does, around the convex outline; "
      "\u201c\u00b1 95 %\u201d is what the noise of the returns lets expect.</p>\n";
  html += Cards(result);
  for (const DemoSubject& subject : result.subjects) html += SubjectHtml(subject);
  return html + "</main>\n</body>\n</html>\n";
}

std::string DemoText(const DemoResult& result) {
  std::string text;
  for (const DemoSubject& subject : result.subjects) {
    text += fmt::format("{}{}\n", text.empty() ? "" : "\n", subject.title);
    const TruthComparison* before = nullptr;
    for (const TruthComparison& row : subject.comparisons) {
      if (before == nullptr || before->group != row.group) {
        text += fmt::format("  {:<26}{:>10} {:>9} {:>10} {:>11}\n", ComparisonGroupName(row.group), "measured",
                            "± 95 %", "true", "difference");
      }
      before = &row;
      text += fmt::format("  {:<26}{:>10} {:>9} {:>10} {:>11} {}\n", row.term, Shown(row.measured, row.unit),
                          Shown(row.half95, row.unit), Shown(row.truth, row.unit), ShownDifference(row), row.unit);
    }
    text += fmt::format("  girths within {:.2f} mm, volume within {:.3f} %\n", LargestGirthError(subject.comparisons),
                        100.0 * LargestVolumeError(subject.comparisons));
  }
  return text;
}

Json DemoJson(const DemoResult& result) {
  Json subjects = Json::array();
  for (const DemoSubject& subject : result.subjects) {
    Json rows = Json::array();
    for (const TruthComparison& row : subject.comparisons) {
      rows.push_back({{"group", ComparisonGroupName(row.group)},
                      {"term", row.term},
                      {"unit", row.unit},
                      {"measured", row.measured},
                      {"half95", JsonNumber(row.half95)},
                      {"true", row.truth},
                      {"difference", row.measured - row.truth}});
    }
    Json files = Json::array();
    for (const DemoFile& file : subject.files) files.push_back(file.name);
    subjects.push_back({{"name", subject.name},
                        {"comparisons", rows},
                        {"largest_girth_error_mm", LargestGirthError(subject.comparisons)},
                        {"largest_volume_error", LargestVolumeError(subject.comparisons)},
                        {"scan",
                         {{"levels", subject.scan.summary.levels},
                          {"missing_levels", subject.scan.summary.missing_levels},
                          {"returns", subject.scan.summary.returns},
                          {"no_returns", subject.scan.summary.no_returns}}},
                        {"fit",
                         {{"coefficients", subject.fit.coefficients},
                          {"noise_sigma_mm", subject.fit.noise_sigma_mm},
                          {"rms_mm", subject.fit.rms_mm},
                          {"rejected", subject.fit.rejected.size()},
                          {"time_s", subject.fit.times.total_s}}},
                        {"shares",
                         {{"measured", subject.shares.measured},
                          {"inferred", subject.shares.inferred},
                          {"unknown", subject.shares.unknown}}},
                        {"files", files}});
  }
  return {{"program_version", ProgramVersion()}, {"seed", result.seed}, {"subjects", subjects}};
}

}  // namespace annulus
