#include "acquisition/drift_history.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/test_storage.h"

namespace annulus {
namespace {

using testing::HasSubstr;

DriftEstimate Estimate(const std::string& hash, const std::string& calibration, double offset) {
  DriftEstimate estimate;
  estimate.scan_hash = hash;
  estimate.ring_serial = "R-1";
  estimate.calibration = calibration;
  estimate.wall_start_ns = 1'700'000'000'000'000'000;
  estimate.duration_s = 26.1;
  estimate.sensors.resize(30);
  for (std::size_t k = 0; k < 30; ++k) {
    if (k == 7) continue;  // saw nothing
    estimate.sensors[k].offset_mm = offset + 0.001 * static_cast<double>(k);
    estimate.sensors[k].sigma_mm = 0.03;
    if (k != 8) estimate.sensors[k].trend_mm_s = 0.00123456;
    if (k != 8) estimate.sensors[k].trend_sigma_mm_s = 0.004;
    estimate.sensors[k].neighbour_weight[4] = static_cast<float>(offset);
  }
  return estimate;
}

ReferenceRecord Check(const std::string& hash) {
  ReferenceRecord check;
  check.scan_hash = hash;
  check.ring_serial = "R-1";
  check.passed = true;
  check.target_radius_mm = 150.0;
  check.sensors.resize(30);
  check.sensors[3].offset_mm = 0.1;
  return check;
}

TEST(DriftHistory, ReadsBackWhatItWroteToTheLastByte) {
  DriftHistory history;
  ASSERT_TRUE(history.Add(Estimate("a", "sha256:1", 0.25), 24.5));
  ASSERT_TRUE(history.Add(Estimate("b", "sha256:1", 0.75)));
  ASSERT_TRUE(history.AddCheck(Check("c")));
  test::TestStorage storage;
  ASSERT_TRUE(history.Save(storage, "ring.drift.json"));
  const auto read = DriftHistory::Load(storage, "ring.drift.json");
  ASSERT_TRUE(read) << read.error().Text();
  EXPECT_EQ(read->ToJson(), history.ToJson());
  ASSERT_EQ(read->records().size(), 2U);
  const DriftRecord& record = read->records()[0];
  EXPECT_EQ(record.scan_hash, "a");
  EXPECT_EQ(record.temperature, 24.5);
  EXPECT_EQ(record.offset_mm[1], 0.251);
  EXPECT_TRUE(std::isnan(record.offset_mm[7]));
  EXPECT_TRUE(std::isnan(record.trend_mm_s[8]));
  EXPECT_EQ(record.trend_mm_s[9], 0.0012);
  EXPECT_EQ(read->stencils()[0][4], 0.5) << "the mean over the scans";
  EXPECT_EQ(read->checks().at(0).sensors.at(3).offset_mm, 0.1);
}

TEST(DriftHistory, TakesEveryScanOnceAndOfOneRingOnly) {
  DriftHistory history;
  ASSERT_EQ(*history.Add(Estimate("a", "x", 0.0)), DriftHistory::Added::kNew);
  ASSERT_EQ(*history.Add(Estimate("a", "x", 0.0)), DriftHistory::Added::kKnown);
  EXPECT_EQ(history.records().size(), 1U);
  DriftEstimate other = Estimate("b", "x", 0.0);
  other.ring_serial = "R-2";
  const auto refused = history.Add(other);
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().Text(), HasSubstr("R-2"));
  other.ring_serial = "R-1";
  other.sensors.resize(29);
  EXPECT_FALSE(history.Add(other));
}

TEST(DriftHistory, BeginsAnewWithEveryCalibration) {
  DriftHistory history;
  ASSERT_TRUE(history.Add(Estimate("a", "x", 0.25)));
  ASSERT_TRUE(history.Add(Estimate("b", "y", 0.75)));
  EXPECT_EQ(history.SinceCalibration(), 1U);
  EXPECT_EQ(history.stencils()[0][4], 0.75);
}

TEST(DriftHistory, StaysBoundedAndKeepsTheBaseline) {
  DriftHistory history;
  const std::size_t many = DriftHistory::kMostRecords + 25;
  ASSERT_TRUE(history.Add(Estimate("old", "before", 0.0)));
  for (std::size_t k = 0; k < many; ++k) ASSERT_TRUE(history.Add(Estimate(std::to_string(k), "x", 0.0)));
  EXPECT_EQ(history.records().size(), DriftHistory::kMostRecords);
  EXPECT_EQ(history.records().front().scan_hash, "0");
  EXPECT_EQ(history.records()[DriftHistory::kKeptFirst - 1].scan_hash, "39");
  EXPECT_EQ(history.records().back().scan_hash, std::to_string(many - 1));
}

TEST(DriftHistory, AMissingFileIsAnEmptyHistory) {
  test::TestStorage storage;
  const auto history = DriftHistory::Load(storage, "none.json");
  ASSERT_TRUE(history);
  EXPECT_EQ(history->records().size(), 0U);
}

TEST(DriftHistory, RefusesWhatIsNoneAndSaysSo) {
  DriftHistory history;
  ASSERT_TRUE(history.Add(Estimate("a", "x", 0.0)));
  const std::string good = history.ToJson();
  const auto with = [&](const std::string& from, const std::string& to) {
    std::string text = good;
    const std::size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    return text.replace(at, from.size(), to);
  };
  const std::vector<std::pair<std::string, std::string>> wrong{
      {"", "not a JSON object"},
      {"[]", "not a JSON object"},
      {good.substr(0, good.size() / 2), "not a JSON object"},
      {std::string(200, '['), "not a JSON object"},
      {with("annulus drift history", "another thing"), "no drift history"},
      {with("\"version\":1", "\"version\":2"), "version 2"},
      {with("\"sensors\":30", "\"sensors\":31"), "offset_mm"},
      {with("\"sensors\":30", "\"sensors\":-1"), "sensors"},
      {with("\"sensors\":30", "\"sensors\":18446744073709551615"), "sensors"},
      {with("0.03", "-0.03"), "sigma_mm"},
      {with("0.03", "1e300"), "sigma_mm"},
      {with("0.03", "\"x\""), "sigma_mm"},
      {with("\"records\":[", "\"records\":[null,"), "records"},
      {with("\"checks\":[]", "\"checks\":[{}]"), "a check"},
  };
  for (const auto& [text, seen] : wrong) {
    const auto read = DriftHistory::FromJson(text, "h.json");
    ASSERT_FALSE(read) << text.substr(0, 80);
    EXPECT_THAT(read.error().seen, HasSubstr(seen));
    EXPECT_THAT(read.error().attempted, HasSubstr("h.json"));
  }
}

TEST(ReferenceRecord, ReadsBackAndIsJudgedByRingCalibrationVerdictAndAge) {
  ReferenceRecord record = Check("s");
  record.wall_start_ns = 1'700'000'000'000'000'000;
  record.calibration = "sha256:1";
  ScanHeader header;
  header.calibration.ring_serial = "R-1";
  header.calibration.certificate = "sha256:1";
  const std::int64_t hour = 3'600'000'000'000;
  const auto judge = [&](std::int64_t later_h) {
    return JudgeReference(record, header, record.wall_start_ns + later_h * hour, std::chrono::hours(24));
  };
  EXPECT_TRUE(judge(23));
  EXPECT_FALSE(judge(25));
  EXPECT_FALSE(judge(-2)) << "a check of tomorrow";
  header.calibration.certificate = "sha256:2";
  EXPECT_THAT(judge(1).error().seen, HasSubstr("calibrated since"));
  header.calibration.certificate = "sha256:1";
  header.calibration.ring_serial = "R-2";
  EXPECT_THAT(judge(1).error().seen, HasSubstr("R-1"));
  header.calibration.ring_serial = "R-1";
  record.passed = false;
  record.findings = {"sensor 3 is off"};
  record.advice = {"clean it"};
  EXPECT_EQ(judge(1).error().seen, "sensor 3 is off");
  EXPECT_EQ(judge(1).error().advice, "clean it");
}

}  // namespace
}  // namespace annulus
