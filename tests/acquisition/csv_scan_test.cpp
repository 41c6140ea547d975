#include "acquisition/csv_scan.h"

#include <gtest/gtest.h>

#include "acquisition/gzip.h"
#include "scan_fixture.h"
#include "tests/support/test_storage.h"

namespace annulus {
namespace {

using test::MakeScan;
using test::SameScan;
using test::StorageFault;
using test::TestStorage;

/// A table that is right: two levels of three sensors.
const std::string kGood =
    "# ring scan; source a mesh; R_mm=600; NaN = no return\n"
    "level,z_mm,sensor,theta_deg,range_mm\n"
    "0,10.000,0,0,243.8253\n"
    "0,10.000,1,120,nan\n"
    "0,10.500,2,240,244\n"
    "1,-5.000,0,0,1.5\n"
    "1,-5.000,1,120,2.5\n"
    "1,-5.000,2,240,3.5\n";

std::string Replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

std::string ErrorOf(const std::string& text) {
  const auto scan = ParseCsvScan(text, "t.csv");
  return scan ? "no error" : scan.error().Text();
}

TEST(ReadCsvScan, TakesTheColumnsOfADesignedTable) {
  const auto scan = ParseCsvScan(kGood, "t.csv");
  ASSERT_TRUE(scan) << scan.error().Text();
  EXPECT_EQ(scan->header.ring_radius_mm, 600.0);
  EXPECT_EQ(scan->header.station_id, "import");
  EXPECT_EQ(scan->header.source, "ring scan; source a mesh; R_mm=600; NaN = no return");
  ASSERT_EQ(scan->header.calibration.sensors.size(), 3U);
  EXPECT_DOUBLE_EQ(scan->header.calibration.sensors[1].theta, 2.0 * kPi / 3.0);
  EXPECT_EQ(scan->header.calibration.sensors[1].radius_mm, 600.0);
  ASSERT_EQ(scan->levels.size(), 2U);
  EXPECT_EQ(scan->levels[0].readings[0].range_mm, 243.8253);
  EXPECT_TRUE(std::isnan(scan->levels[0].readings[1].range_mm));
  EXPECT_EQ(scan->levels[0].readings[2].z_mm, 10.5);
  EXPECT_EQ(scan->levels[1].readings[0].z_mm, -5.0);
}

TEST(ReadCsvScan, TakesAnyOrderOfColumnsAndRowsCarriageReturnsBlanksAndStrangeColumns) {
  const auto scan = ParseCsvScan(
      "\xEF\xBB\xBFrange_mm , comment,sweep,theta_deg,t_s,sensor,z_mm,level\r\n"
      "# R_mm=600 between the rows is as good\r\n"
      "3.5,x,1,240,0.25,2,-5,0\r\n"
      "\r\n"
      " NaN,,0,0,-1.000000001,0,10,7\r\n"
      "+1.5,y,1,0,0.125,0,-5,0",
      "t.csv");
  ASSERT_TRUE(scan) << scan.error().Text();
  ASSERT_EQ(scan->levels.size(), 2U);
  EXPECT_EQ(scan->levels[0].sweep, 0);
  EXPECT_EQ(scan->levels[0].index, 7U);
  EXPECT_EQ(scan->levels[0].time.count(), -1'000'000'001);
  EXPECT_EQ(scan->levels[1].sweep, 1);
  EXPECT_EQ(scan->levels[1].time.count(), 125'000'000);  // the earliest of its rows
  EXPECT_EQ(scan->levels[1].readings[0].range_mm, 1.5);
  EXPECT_TRUE(std::isnan(scan->levels[1].readings[1].range_mm));  // no row: no return
  EXPECT_EQ(scan->levels[1].readings[1].z_mm, -5.0);
  EXPECT_EQ(scan->levels[1].readings[2].range_mm, 3.5);
}

struct BadTable {
  const char* name;
  std::string text;
  std::string error;
};

TEST(ReadCsvScan, SaysInOneLineWhatIsWrongAndWhere) {
  const std::string header_only = "# R_mm=600\nlevel,z_mm,sensor,theta_deg,range_mm\n";
  const BadTable tables[] = {
      {"empty", "", "it is empty"},
      {"only comments", "# R_mm=600\n# nothing\n", "it has no row of numbers"},
      {"no rows", header_only, "it has no row of numbers"},
      {"missing column", Replaced(kGood, ",range_mm", ",range"), "line 2: the column range_mm is missing"},
      {"no names", "# R_mm=600\n0,1,2,3,4\n", "line 2: the column level is missing"},
      {"semicolons", "# R_mm=600\nlevel;z_mm;sensor;theta_deg;range_mm\n", "line 2: the column level is missing"},
      {"column twice", Replaced(kGood, "theta_deg,", "z_mm,"), "line 2: the column z_mm stands twice"},
      {"letters", Replaced(kGood, "243.8253", "abc"), "line 3: range_mm is 'abc', not a number"},
      {"trailing letters", Replaced(kGood, "243.8253", "243.8mm"), "line 3: range_mm is '243.8mm', not a number"},
      {"infinite", Replaced(kGood, "243.8253", "inf"), "line 3: range_mm is 'inf', beyond 10000"},
      {"overflow", Replaced(kGood, "243.8253", "1e999"), "line 3: range_mm is '1e999', beyond 10000"},
      {"negative", Replaced(kGood, "243.8253", "-3"), "line 3: range_mm is '-3', negative"},
      {"huge", Replaced(kGood, "243.8253", "10001"), "line 3: range_mm is '10001', beyond 10000"},
      {"nan height", Replaced(kGood, "0,10.000,0", "0,nan,0"), "line 3: z_mm is 'nan', beyond 1e+05"},
      {"huge height", Replaced(kGood, "0,10.000,0", "0,1e6,0"), "line 3: z_mm is '1e6', beyond 1e+05"},
      {"no height", Replaced(kGood, "0,10.000,0", "0,,0"), "line 3: z_mm is '', not a number"},
      {"half sensor", Replaced(kGood, "10.500,2,", "10.500,2.5,"),
       "line 5: sensor is '2.5', not a whole number from 0 to 65535"},
      {"negative level", Replaced(kGood, "1,-5.000,0", "-1,-5.000,0"),
       "line 6: level is '-1', not a whole number from 0 to 1000000"},
      {"few fields", Replaced(kGood, ",1.5", ""), "line 6: it has 4 fields, the table has 5 columns"},
      {"decimal comma", Replaced(kGood, ",1.5", ",1,5"), "line 6: it has 6 fields, the table has 5 columns"},
      {"theta moves", Replaced(kGood, "1,-5.000,2,240", "1,-5.000,2,241"),
       "line 8: theta_deg of sensor 2 differs from its earlier value"},
      {"cell twice", Replaced(kGood, "1,-5.000,2,240", "1,-5.000,1,120"),
       "line 8: sweep 0, level 1, sensor 1 was given before on line 7"},
      {"no radius", Replaced(kGood, "R_mm", "Rmm"), "no comment line says the ring's radius"},
      {"bad radius", Replaced(kGood, "R_mm=600", "R_mm=0"), "line 1: R_mm is '0; NaN = no return', not a number in"},
      {"two radii", "# R_mm=500\n" + kGood, "line 2: R_mm is given twice with different values"},
      {"single level", kGood.substr(0, kGood.find("1,-5.000,0")), "it has a single level"},
      {"no return", header_only + "0,1,0,0,nan\n1,1,0,0,nan\n", "it has no return at all"},
      {"sparse", header_only + "0,1,0,0,5\n1,1,65535,0,5\n",
       "its 2 rows fill less than 1/64 of 2 levels of 65536 sensors"},
      {"binary",
       std::string("\x7f"
                   "ELF\0\0\0",
                   7),
       "line 1: it holds binary data"},
      {"recording", std::string("\x89MCAP0\r\n\x01\0", 10), "it is a recording already"},
      {"bad header", Replaced(kGood, "NaN =", "annulus_scan={"),
       "line 1: the header after 'annulus_scan=' is unusable"},
  };
  for (const BadTable& table : tables) {
    const std::string error = ErrorOf(table.text);
    EXPECT_EQ(error.rfind("read t.csv: " + table.error, 0), 0U) << table.name << ": " << error;
    EXPECT_EQ(error.find('\n'), std::string::npos);
  }
}

TEST(ReadCsvScan, ShowsForeignBytesAsPlainText) {
  const std::string error = ErrorOf(Replaced(kGood, "243.8253", "\x1b[31m\xff a text without an end and more"));
  EXPECT_EQ(error.rfind("read t.csv: line 3: range_mm is '?[31m? a text without an…'", 0), 0U) << error;
}

TEST(ReadCsvScan, ReadsGzipByItsFirstBytesNotByItsName) {
  GzipPacker packer;
  std::string packed = packer.Pack(kGood);
  packed += packer.Finish();
  const auto bytes = std::as_bytes(std::span(packed));
  TestStorage storage;
  storage.files["t.csv"] = {bytes.begin(), bytes.end()};
  const auto scan = ReadCsvScan(storage, "t.csv");
  ASSERT_TRUE(scan) << scan.error().Text();
  EXPECT_EQ(scan->levels.size(), 2U);
}

TEST(WriteCsvScan, GivesTheSameScanBackPlainAndPacked) {
  Scan scan = MakeScan(6, 9);
  scan.header.subject_id.clear();
  scan.header.consent_reference.clear();
  scan.levels[5].sweep = 1;
  scan.levels[5].index = 0;
  scan.levels[0].time = std::chrono::nanoseconds(9'000'000'000'000'000'00LL);
  for (const std::string path : {"t.csv", "t.csv.gz"}) {
    TestStorage storage;
    ASSERT_TRUE(WriteCsvScan(storage, path, scan));
    const auto read = ReadCsvScan(storage, path);
    ASSERT_TRUE(read) << read.error().Text();
    EXPECT_TRUE(SameScan(*read, scan));
    EXPECT_EQ(storage.files.size(), 1U);
  }
}

TEST(WriteCsvScan, GivesAnImportedTableBackAsTheSameScan) {
  const auto imported = ParseCsvScan(kGood, "t.csv");
  ASSERT_TRUE(imported);
  TestStorage storage;
  ASSERT_TRUE(WriteCsvScan(storage, "t.csv", *imported));
  const auto read = ReadCsvScan(storage, "t.csv");
  ASSERT_TRUE(read) << read.error().Text();
  EXPECT_TRUE(SameScan(*read, *imported));
}

TEST(WriteCsvScan, WritesCalibratedPointsAndWeights) {
  // Sensor 0 at +x, R = 600: a range of 243.8253 is the point (356.1747, 0, 10). Sensor 2 at 240 degrees: range 244
  // is 356 * (cos 240, sin 240) = (-178, -308.3050). Level 1, sensor 0: 598.5.
  const auto scan = ParseCsvScan(kGood, "t.csv");
  ASSERT_TRUE(scan);
  TestStorage storage;
  ASSERT_TRUE(WriteCsvScan(storage, "t.csv", *scan));
  const auto& bytes = storage.files["t.csv"];
  const std::string text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  EXPECT_EQ(text.rfind("# R_mm=600; ", 0), 0U);
  const std::string rows = text.substr(text.find('\n') + 1);
  EXPECT_EQ(rows.rfind("level,z_mm,sensor,theta_deg,range_mm,t_s,sweep,x_cal_mm,y_cal_mm,z_cal_mm,weight\n"
                       "0,10,0,0,243.8253,0,0,356.1747,0.0000,10.0000,1\n"
                       "0,10,1,120,nan,0,0,,,,\n"
                       "0,10.5,2,240,244,0,0,-178.0000,-308.3050,10.5000,1\n"
                       "1,-5,0,0,1.5,0,0,598.5000,0.0000,-5.0000,1\n",
                       0),
            0U)
      << rows;
}

TEST(WriteCsvScan, DoesNotHandOnWhoWasScanned) {
  Scan scan = MakeScan(2, 3);
  scan.header.subject_id = "SUBJECT-MARK";
  scan.header.consent_reference = "CONSENT-MARK";
  TestStorage storage;
  ASSERT_TRUE(WriteCsvScan(storage, "t.csv", scan));
  const auto& bytes = storage.files["t.csv"];
  const std::string text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  EXPECT_EQ(text.find("-MARK"), std::string::npos);
}

TEST(ReadCsvScan, RefusesAnExportedTableWhoseRowsNoLongerFitItsHeader) {
  TestStorage storage;
  ASSERT_TRUE(WriteCsvScan(storage, "t.csv", MakeScan(2, 3)));
  const auto& bytes = storage.files["t.csv"];
  const std::string text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  EXPECT_NE(ErrorOf(Replaced(text, "# R_mm=600.1", "# R_mm=601")).find("R_mm differs"), std::string::npos);
  std::string turned = text;
  for (std::size_t at = turned.find(",120,"); at != std::string::npos; at = turned.find(",120,")) turned[at + 3] = '1';
  EXPECT_NE(ErrorOf(turned).find("theta_deg of sensor 1 differs from the header"), std::string::npos)
      << ErrorOf(turned);
}

TEST(WriteCsvScan, LeavesNothingBehindWhicheverCallFails) {
  const Scan scan = MakeScan(4, 3);
  for (const std::string path : {"t.csv", "t.csv.gz"}) {
    for (std::uint64_t n = 1;; ++n) {
      TestStorage storage;
      storage.files[path] = {std::byte{'o'}};
      storage.FailCall(n, StorageFault::kShortWrite);
      const Status status = WriteCsvScan(storage, path, scan);
      if (!storage.fault_hit()) {
        EXPECT_TRUE(status);
        EXPECT_GT(n, 4U);
        break;
      }
      ASSERT_FALSE(status) << "call " << n;
      ASSERT_EQ(storage.files.size(), 1U) << "call " << n;
      ASSERT_EQ(storage.files[path].size(), 1U) << "call " << n;
    }
  }
}

}  // namespace
}  // namespace annulus
