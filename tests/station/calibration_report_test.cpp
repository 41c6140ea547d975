#include "station/calibration_report.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cstdio>
#include <filesystem>
#include <limits>
#include <memory>
#include <stdexcept>
#include <string>

#include "station/calibration_plots.h"
#include "station/calibration_verdict.h"
#include "tests/station/sample_calibration.h"
#include "tests/support/folders.h"
#include "tests/support/test_storage.h"

namespace annulus {
namespace {

using test::SampleReport;
using testing::HasSubstr;
using testing::Not;
using Verdict = LimitLine::Verdict;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// What a program prints, and whether it is content.
struct Printed {
  std::string text;
  bool succeeded = false;
};

Printed Execute(const std::string& command) {
  Printed printed;
  std::FILE* pipe = ::popen((command + " 2>&1").c_str(), "r");
  if (pipe == nullptr) throw std::runtime_error("no shell");
  std::array<char, 4096> part{};
  while (const std::size_t count = std::fread(part.data(), 1, part.size(), pipe))
    printed.text.append(part.data(), count);
  printed.succeeded = ::pclose(pipe) == 0;
  return printed;
}

bool Installed(const std::string& program) { return Execute("command -v " + program).succeeded; }

/// Writes into the build folder, where the files stay to be looked at.
std::string Written(const std::string& name, const CalibrationReport& report) {
  std::string folder = test::BinaryFolder() + "/calibration_report/" + name;
  PosixStorage storage;
  const Status status = WriteCalibrationReport(storage, folder, report);
  if (!status) throw std::runtime_error(status.error().Text());
  return folder;
}

const LimitLine& LineOf(const std::vector<LimitLine>& lines, const std::string& begin) {
  for (const LimitLine& line : lines) {
    if (line.name.starts_with(begin)) return line;
  }
  throw std::runtime_error("no line " + begin);
}

const std::vector<std::string>& Sections() {
  static const std::vector<std::string> sections{"Targets",
                                                 "As found and as left",
                                                 "What was done",
                                                 "Findings",
                                                 "Radial errors around the ring",
                                                 "Where the beams point",
                                                 "Residuals",
                                                 "Placements",
                                                 "The carriage's way",
                                                 "Shapes of the targets",
                                                 "What is known and what is not",
                                                 "Error budget",
                                                 "Verification on a second artefact",
                                                 "How the lines of the certificate are found",
                                                 "Calibrations of this ring"};
  return sections;
}

TEST(CalibrationVerdict, AsFoundIsWhatTheOldCalibrationHadWrong) {
  // Every point 0.7 mm too far out, and one sensor 1 mm more: 1/180 of that is common, a little a shift of the centre.
  RingCalibration before = RingCalibration::Ideal(600.0);
  for (SensorCalibration& sensor : before.sensors) sensor.range_offset_mm = -0.7;
  before.sensors[40].range_offset_mm -= 1.0;
  before.sensors[90].aim_lateral = 0.002;
  before.sensors[91].aim_vertical = -0.003;
  const AsFound found = AsFoundOf(before, RingCalibration::Ideal(600.0));
  EXPECT_NEAR(found.common_mm, 0.7 + 1.0 / 180.0, 1e-3);
  EXPECT_NEAR(found.radial_mm[40], 1.0, 0.02);
  EXPECT_NEAR(found.radial_mm[41], 0.0, 0.02);
  EXPECT_NEAR(found.lateral_rad[90], 0.002, 5e-5);
  EXPECT_NEAR(found.lateral_rad[91], 0.0, 5e-5);
  EXPECT_NEAR(found.vertical_rad[91], -0.003, 5e-5);
  EXPECT_NEAR(found.vertical_rad[90], 0.0, 5e-5);
}

TEST(CalibrationVerdict, ComparesAtTheTemperatureOfTheNewOne) {
  RingCalibration before = RingCalibration::Ideal(600.0);
  before.range_mm_per_c = 0.05;
  RingCalibration left = before;
  left.reference_c = 26.0;
  for (SensorCalibration& sensor : left.sensors) sensor.range_offset_mm = 0.3;  // what six degrees make
  EXPECT_NEAR(AsFoundOf(before, left).common_mm, 0.0, 1e-9);
}

TEST(CalibrationVerdict, AShiftAndATurnOfTheRingAreNoErrors) {
  RingCalibration before = RingCalibration::Ideal(600.0);
  before.pose.x_mm = 3.0;
  for (SensorCalibration& sensor : before.sensors) sensor.theta += 0.004;
  const AsFound found = AsFoundOf(before, RingCalibration::Ideal(600.0));
  EXPECT_NEAR(found.common_mm, 0.0, 0.01);
  for (std::size_t i = 0; i < 180; ++i) {
    EXPECT_NEAR(found.radial_mm[i], 0.0, 0.02);
    EXPECT_NEAR(found.lateral_rad[i], 0.0, 1e-4);
  }
}

TEST(CalibrationVerdict, TheSolversOwnCorrectionsSayTheSameAsFound) {
  CalibrationReport report = SampleReport();
  const SensorErrors by_points = SensorErrorsOf(report);
  report.as_found.reset();  // then out of the corrections of the ideal ring that the solve began with
  const SensorErrors by_corrections = SensorErrorsOf(report);
  for (std::size_t i = 0; i < 180; ++i) {
    // Corrections are of first order: an aim of 1.5 degrees shortens 450 mm by 0.15 mm.
    EXPECT_NEAR(by_corrections.before_mm[i], by_points.before_mm[i], 0.2) << i;
    EXPECT_NEAR(by_corrections.lateral_deg[i], by_points.lateral_deg[i], 0.01) << i;
  }
}

TEST(CalibrationVerdict, EnDividesByBothUncertainties) {
  CalibrationVerification seen;
  seen.found_radius_mm = 100.05;
  seen.certified_radius_mm = 100.0;
  seen.found_u_mm = 0.03;
  seen.certified_u_mm = 0.04;
  EXPECT_NEAR(seen.En(), 1.0, 1e-9);
  seen.found_u_mm = seen.certified_u_mm = 0.0;
  EXPECT_EQ(seen.En(), kInfinity);
  seen.found_radius_mm = 100.0;
  EXPECT_EQ(seen.En(), 0.0);
}

TEST(CalibrationVerdict, APlainSampleIsWithinEveryLimit) {
  const CalibrationReport report = SampleReport();
  for (const LimitLine& line : JudgeCalibration(report)) EXPECT_EQ(line.left_verdict(), Verdict::kPass) << line.name;
  EXPECT_TRUE(CalibrationPasses(report));
}

TEST(CalibrationVerdict, AsFoundFailsOfAnIdealRingAndAsLeftDoesNot) {
  const auto lines = JudgeCalibration(SampleReport());
  EXPECT_EQ(LineOf(lines, "Radial error common").found_verdict(), Verdict::kFail);
  EXPECT_EQ(LineOf(lines, "Radial error of single").found_verdict(), Verdict::kFail);
  EXPECT_NEAR(*LineOf(lines, "Girth").found, kTwoPi * *LineOf(lines, "Radial error common").found, 1e-9);
}

TEST(CalibrationVerdict, EachLimitAloneFailsTheCalibration) {
  const auto fails_with = [](const auto& change) {
    CalibrationReport report = SampleReport();
    change(report);
    return !CalibrationPasses(report);
  };
  EXPECT_TRUE(fails_with([](CalibrationReport& r) { r.limits.common_mm = 1e-4; }));
  EXPECT_TRUE(fails_with([](CalibrationReport& r) { r.limits.sensor_rms_mm = 1e-4; }));
  EXPECT_TRUE(fails_with([](CalibrationReport& r) { r.limits.lateral_deg = 1e-4; }));
  EXPECT_TRUE(fails_with([](CalibrationReport& r) { r.limits.vertical_deg = 1e-4; }));
  EXPECT_TRUE(fails_with([](CalibrationReport& r) { r.limits.girth_mm = 1e-4; }));
  EXPECT_TRUE(fails_with([](CalibrationReport& r) { r.verification->found_radius_mm += 0.1; }));
  EXPECT_TRUE(fails_with([](CalibrationReport& r) { r.verification->residual_rms_mm = 0.5; }));
  EXPECT_TRUE(fails_with([](CalibrationReport& r) {
    r.solution.findings.push_back({CalibrationFinding::Grade::kFailure, "target_moved", "it moved", "scan it again"});
  }));
  // What is not a number is within no limit.
  EXPECT_TRUE(fails_with([](CalibrationReport& r) { r.solution.common_sigma_mm[3] = kInfinity; }));
  EXPECT_TRUE(fails_with([](CalibrationReport& r) { r.solution.budget.back().girth_mm = kInfinity - kInfinity; }));
}

TEST(CalibrationVerdict, WhatIsLeftComesFromTheCovariances) {
  CalibrationReport report = SampleReport();
  RingSolution& solution = report.solution;
  solution.common_sigma_mm.setConstant(0.02);
  solution.common_sigma_mm[6] = 0.05;
  solution.sensor_sigma_mm.setConstant(0.1);
  for (auto& covariance : solution.sensor_covariance) {
    covariance.setZero();
    covariance(sensor_unknown::kTangential, sensor_unknown::kTangential) = 0.09;  // mm^2
    covariance(sensor_unknown::kLateral, sensor_unknown::kLateral) = 0.16;
    covariance(sensor_unknown::kHeight, sensor_unknown::kHeight) = 1.0;
    covariance(sensor_unknown::kVertical, sensor_unknown::kVertical) = 1.0;
    covariance(sensor_unknown::kHeight, sensor_unknown::kVertical) = -0.5;  // a beam that is known half-way
    covariance(sensor_unknown::kVertical, sensor_unknown::kHeight) = -0.5;
  }
  const auto lines = JudgeCalibration(report);
  EXPECT_NEAR(*LineOf(lines, "Radial error common").left, 1.96 * 0.05, 1e-4);
  EXPECT_NEAR(*LineOf(lines, "Radial error of single").left, 0.1, 1e-9);
  EXPECT_NEAR(*LineOf(lines, "Sideways").left, 0.5 / 450.0 * 180.0 / 3.14159265, 1e-6);  // sqrt(0.09 + 0.16) mm
  EXPECT_NEAR(*LineOf(lines, "Error of the beams in height").left, 1.0 / 450.0 * 180.0 / 3.14159265, 1e-6);
}

TEST(CalibrationVerdict, WithoutASecondArtefactItPassesUnverified) {
  CalibrationReport report = SampleReport();
  report.verification.reset();
  EXPECT_EQ(LineOf(JudgeCalibration(report), "Second artefact: En").left_verdict(), Verdict::kNotChecked);
  EXPECT_TRUE(CalibrationPasses(report));
  EXPECT_THAT(CalibrationReportHtml(report), HasSubstr("PASS, NOT VERIFIED"));
}

TEST(CalibrationVerdict, IsTraceableOnlyIfEveryTargetOfTheSolveHasACertificate) {
  CalibrationReport report = SampleReport();
  EXPECT_TRUE(TraceabilityOf(report).traceable);
  EXPECT_THAT(TraceabilityOf(report).statement, HasSubstr("2026-0417"));
  report.targets[1].target.certificate_number.clear();
  EXPECT_FALSE(TraceabilityOf(report).traceable);
  EXPECT_EQ(TraceabilityOf(report).statement, "not traceable: the target C070-11 has no certificate");
  // A target that nobody scanned carries nothing.
  for (PlacementResult& placement : report.solution.placements) placement.target = 0;
  EXPECT_TRUE(TraceabilityOf(report).traceable);
  report.targets[0].target.expanded_u_mm = 0.0;
  EXPECT_THAT(TraceabilityOf(report).statement, HasSubstr("states no uncertainty"));
  // The second artefact's certificate does not make up for the target's.
  report.targets.resize(1);
  report.targets[0].target.certificate_number.clear();
  report.targets[0].target.serial.clear();
  EXPECT_EQ(TraceabilityOf(report).statement, "not traceable: the target has no certificate");
}

TEST(CalibrationReport, HasEverySectionOnScreen) {
  const std::string html = CalibrationReportHtml(SampleReport());
  for (const std::string& section : Sections()) EXPECT_THAT(html, HasSubstr("<h2>" + section)) << section;
  for (const char* words : {"PASS", "Traceable to the certificates 2026-0417", "floor", "M. Sato", "2026-08-30",
                            "AR-0042", "C100-02", "21.6 °C", "Z scale", "this one"}) {
    EXPECT_THAT(html, HasSubstr(words));
  }
}

TEST(CalibrationReport, CallsUTheFloorAndSaysWhatItIsOfAGirth) {
  // 2 pi 0.020 mm, and 2 U / r of the area of a circle of 900 mm.
  EXPECT_THAT(CalibrationReportHtml(SampleReport()),
              testing::AllOf(HasSubstr("is the floor of the error common to all sensors"),
                             HasSubstr("U = 0.020 mm (k = 2) is 0.13 mm of every girth (2π·U) and 0.028 % of volume")));
  CalibrationReport report = SampleReport();
  for (ReportTarget& target : report.targets) target.target.expanded_u_mm = 0.0;
  EXPECT_THAT(CalibrationReportHtml(report), HasSubstr("No uncertainty was entered for the targets"));
}

TEST(CalibrationReport, NamesPlacementsWithoutFoldersAndEndings) {
  CalibrationReport report = SampleReport();
  report.solution.placements[2].name = "some/where/p3.mcap";
  const std::string html = CalibrationReportHtml(report);
  EXPECT_THAT(html, HasSubstr("<td>p3</td>"));
  EXPECT_THAT(html, Not(HasSubstr("some/where")));
}

TEST(CalibrationReport, SaysWithoutACertificateThatItIsNotTraceable) {
  CalibrationReport report = SampleReport();
  for (ReportTarget& target : report.targets) target.target.certificate_number.clear();
  const std::string html = CalibrationReportHtml(report);
  EXPECT_THAT(html, HasSubstr("Not traceable: the target C150-03 has no certificate"));
  EXPECT_THAT(html, Not(HasSubstr("raceable to the certificates")));
}

TEST(CalibrationReport, AsksForNothingElse) {
  const std::string html = CalibrationReportHtml(SampleReport());
  EXPECT_THAT(html, Not(HasSubstr("<script")));
  EXPECT_THAT(html, Not(HasSubstr("<link")));
  EXPECT_THAT(html, Not(HasSubstr("src=")));
  EXPECT_THAT(html, Not(HasSubstr("url(")));
  std::size_t at = 0;
  while ((at = html.find("href=\"", at)) != std::string::npos) {
    EXPECT_EQ(html.substr(at, 27), "href=\"data:image/png;base64");
    ++at;
  }
}

TEST(CalibrationReport, TextsThatWereEnteredCannotBecomeMarkup) {
  CalibrationReport report = SampleReport();
  report.technician = "<b>&\"x";
  const std::string html = CalibrationReportHtml(report);
  EXPECT_THAT(html, HasSubstr("&lt;b&gt;&amp;&quot;x"));
  EXPECT_THAT(html, Not(HasSubstr("<b>&\"")));
}

TEST(CalibrationReport, IsTheSameEachTime) {
  const CalibrationReport report = SampleReport();
  EXPECT_EQ(CalibrationReportHtml(report), CalibrationReportHtml(report));
  const auto first = CalibrationReportPdf(report);
  const auto second = CalibrationReportPdf(report);
  ASSERT_TRUE(first) << first.error().Text();
  EXPECT_EQ(*first, *second);
}

TEST(CalibrationReport, DoesNotSayHowLongTheSolveTook) {
  CalibrationReport report = SampleReport();
  const std::string before = CalibrationReportHtml(report);
  report.solution.time_s += 12.0;
  EXPECT_EQ(CalibrationReportHtml(report), before);
}

/// What goes wrong all at once.
CalibrationReport BadReport() {
  CalibrationReport report = SampleReport();
  report.as_found.reset();
  report.verification.reset();
  report.ambient_c.reset();
  report.history.clear();
  report.technician.clear();
  report.limits.girth_mm = 0.05;
  for (ReportTarget& target : report.targets) target.target.certificate_number.clear();
  report.solution.findings = {
      {CalibrationFinding::Grade::kFailure, "target_moved", "placement 3: two sweeps saw the target 0.42 mm apart",
       "the target moved or was touched while it was scanned: the errors of all sensors take part of that; scan this "
       "placement again and leave the target alone"},
      {CalibrationFinding::Grade::kWarning, "few_placements",
       "2 placements stood more than 50 mm off the centre and 1 were tilted by more than 3 degrees",
       "sideways and vertical aims rest on few readings; add placements off the centre and tilted in other directions"},
      {CalibrationFinding::Grade::kNote, "one_radius", "only one target's radius was used",
       "a wrong radius would go into all girths unseen (0.1 mm is 0.6 mm of girth); verify with a second target"}};
  for (Observability& entry : report.solution.observability) {
    if (entry.name != "z scale" && entry.name != "offset against radial position") continue;
    entry.observable = false;
    entry.consequence =
        "No target had edges at known heights: heights and volumes keep the drive's own scale. Scan a step gauge to "
        "know "
        "it.";
  }
  for (std::size_t i = 0; i < 180; ++i) {
    if (i < 30 || i >= 45) report.solution.sensor_covariance[i].setZero();
  }
  return report;
}

TEST(CalibrationReport, SaysWhatWentWrong) {
  const std::string html = CalibrationReportHtml(BadReport());
  for (const char* words : {"<b>FAIL</b>", "must not be used", "Girth of 900 mm; Findings of grade failure",
                            "0.42 mm apart.", "failure", "Not verified", "not entered", "nothing that is known of",
                            "Scan a step gauge to know it.", "Left as they were: 0–29, 45–179."}) {
    EXPECT_THAT(html, HasSubstr(words));
  }
}

TEST(CalibrationReport, WritesEachFileWholeOrNotAtAll) {
  const CalibrationReport report = SampleReport();
  test::TestStorage storage;
  ASSERT_TRUE(WriteCalibrationReport(storage, "cal", report));
  for (const char* name :
       {"cal/report.html", "cal/report.pdf", "cal/plots/radial_errors.png", "cal/plots/aim_errors.png",
        "cal/plots/residual_maps.png", "cal/plots/placement_residuals.png", "cal/plots/straightness.png",
        "cal/plots/roundness.png", "cal/plots/budget.png", "cal/plots/verification.png"}) {
    EXPECT_TRUE(storage.files.contains(name)) << name;
  }
  EXPECT_EQ(storage.files.size(), 10U);
  for (const std::uint64_t call : {std::uint64_t{3}, storage.calls() - 2}) {
    test::TestStorage faulty;
    faulty.FailCall(call, test::StorageFault::kShortWrite);
    EXPECT_FALSE(WriteCalibrationReport(faulty, "cal", report));
    for (const auto& [name, bytes] : faulty.files) EXPECT_EQ(bytes, storage.files[name]) << name;
  }
}

TEST(CalibrationReport, IsWellFormed) {
  if (!Installed("xmllint")) GTEST_SKIP() << "xmllint is not installed: apt-get install libxml2-utils";
  for (const auto& folder : {Written("full", SampleReport()), Written("bad", BadReport())}) {
    const Printed checked = Execute("xmllint --noout '" + folder + "/report.html'");
    EXPECT_TRUE(checked.succeeded) << checked.text;
  }
}

TEST(CalibrationReport, HasTheSameSectionsOnPaper) {
  if (!Installed("pdftotext")) GTEST_SKIP() << "poppler is not installed: apt-get install poppler-utils";
  const Printed paper = Execute("pdftotext -layout '" + Written("full", SampleReport()) + "/report.pdf' -");
  ASSERT_TRUE(paper.succeeded) << paper.text;
  for (const std::string& section : Sections()) EXPECT_THAT(paper.text, HasSubstr(section));
  for (const char* words : {"PASS", "Traceable", "2026-0417", "M. Sato", "page 1 of ", "150.000 ± 0.020 mm"}) {
    EXPECT_THAT(paper.text, HasSubstr(words));
  }
}

TEST(CalibrationReport, OfASolutionWithNothingInItStillHasItsPages) {
  CalibrationReport report;
  report.solution.calibration = RingCalibration::Ideal(600.0);
  report.solution.corrections.sensors.assign(180, SensorUnknowns::Zero());
  const std::string html = CalibrationReportHtml(report);
  EXPECT_THAT(html, HasSubstr("Not traceable: no target was scanned"));
  const auto pdf = CalibrationReportPdf(report);
  EXPECT_TRUE(pdf) << pdf.error().Text();
}

TEST(CalibrationPlots, ShowPlacementsWhileMoreAreToCome) {
  PlacementResidual first{"placement 1", 1.24, std::numeric_limits<double>::quiet_NaN()};
  const Figure live = DrawPlacementResiduals({first, {"placement 2"}, {"placement 3"}});
  EXPECT_THAT(live.ToSvg(), HasSubstr("to come"));
  EXPECT_THAT(live.ToSvg(), HasSubstr("1.24"));
  EXPECT_TRUE(live.ToImage(4.0));
  EXPECT_TRUE(DrawPlacementResiduals({}).ToImage(4.0));
}

}  // namespace
}  // namespace annulus
