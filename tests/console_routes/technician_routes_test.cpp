#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "acquisition/recording.h"
#include "tests/console_routes/recorded_scan.h"
#include "tests/console_routes/route_console.h"

namespace annulus {
namespace {

using Json = nlohmann::json;

class TechnicianRoutes : public testing::Test {
 protected:
  test::RouteConsole console;
};

TEST_F(TechnicianRoutes, TheDoctorLooksAtTheSimulatedBooth) {
  const auto answer = console.Ask("POST", "/api/technician/doctor");
  ASSERT_EQ(answer.status, 200) << answer.json;
  ASSERT_EQ(answer.json["state"], "done") << answer.json;
  std::set<std::string> groups;
  for (const Json& item : answer.json["result"]["items"]) groups.insert(item["group"].get<std::string>());
  EXPECT_TRUE(groups.contains("ring"));
  EXPECT_TRUE(groups.contains("interlock"));
  EXPECT_EQ(console.Ask("POST", "/api/technician/doctor", {{"test", true}}).field, "test");
}

TEST_F(TechnicianRoutes, SensorsAreThoseOfTheNewestRecording) {
  console.store.AddRecorded("belt", test::BeltRecording());
  console.store.AddRecorded("belt", {});
  const auto answer = console.Ask("GET", "/api/technician/sensors");
  ASSERT_EQ(answer.status, 200) << answer.json;
  EXPECT_EQ(answer.json["scan_id"], "S-1");
  ASSERT_EQ(answer.json["sensors"].size(), 180U);
  // Shares and means by plain counting.
  const Scan scan = ParseRecording(test::BeltRecording(), "belt").value().scan;
  for (const std::size_t sensor : {std::size_t{0}, std::size_t{45}, std::size_t{179}}) {
    double sum = 0.0;
    int count = 0;
    for (const ScanLevel& level : scan.levels) {
      if (!std::isfinite(level.readings[sensor].range_mm)) continue;
      sum += level.readings[sensor].range_mm;
      ++count;
    }
    const Json& row = answer.json["sensors"][sensor];
    EXPECT_EQ(row["angle_deg"], 2.0 * static_cast<double>(sensor));
    EXPECT_NEAR(row["returns_share"].get<double>(), count / static_cast<double>(scan.levels.size()), 1e-12);
    EXPECT_NEAR(row["mean_mm"].get<double>(), sum / count, 1e-9);
    EXPECT_EQ(row["alarm"], false);
  }
}

TEST_F(TechnicianRoutes, WithoutAScanThereAreNoSensors) {
  const auto answer = console.Ask("GET", "/api/technician/sensors");
  ASSERT_EQ(answer.status, 200);
  EXPECT_TRUE(answer.json["sensors"].empty());
  EXPECT_TRUE(answer.json["scan_id"].is_null());
}

TEST_F(TechnicianRoutes, DriftIsTakenUpScanByScanAndOnlyOnce) {
  EXPECT_EQ(console.Ask("POST", "/api/technician/drift/update").status, 409);
  console.store.AddRecorded("belt", test::BeltRecording());
  const auto updated = console.Ask("POST", "/api/technician/drift/update");
  ASSERT_EQ(updated.json["state"], "done") << updated.json;
  EXPECT_EQ(updated.json["result"]["scans_added"], 1);
  EXPECT_EQ(console.Ask("POST", "/api/technician/drift/update").status, 409);
  const auto drift = console.Ask("GET", "/api/technician/drift");
  ASSERT_EQ(drift.status, 200) << drift.json;
  EXPECT_EQ(drift.json["scans"], 1);
  EXPECT_EQ(drift.json["baseline_ready"], false);
  ASSERT_EQ(drift.json["sensors"].size(), 180U);
  EXPECT_TRUE(drift.json["alarms"].empty());
  EXPECT_TRUE(drift.json["reference_check"].is_null());
}

TEST_F(TechnicianRoutes, ParametersSayWhereTheyComeFrom) {
  const auto answer = console.Ask("GET", "/api/technician/parameters");
  ASSERT_EQ(answer.status, 200);
  EXPECT_EQ(answer.json["path"], "sim");
  bool found = false;
  for (const Json& section : answer.json["sections"]) {
    for (const Json& key : section["values"]) {
      EXPECT_EQ(key["source"], "built in");
      if (section["name"] == "ring" && key["key"] == "radius_mm") found = key["value"] == 600.0;
    }
  }
  EXPECT_TRUE(found);
}

TEST(Parameters, OfAFileHaveTheirLines) {
  const std::string text = "[station]\nid = \"booth-7\"\n\n[profile.body]\npitch_mm = 4.0\n";
  const std::string path = test::BinaryFolder() + "/console-routes-parameters.toml";
  PosixStorage storage;
  ASSERT_TRUE(WriteFileAtomically(storage, path, text));
  test::RouteConsole console(ParseConfig(text, "text").value());
  console.context.config_path = path;
  const auto answer = console.Ask("GET", "/api/technician/parameters");
  ASSERT_EQ(answer.status, 200) << answer.json;
  EXPECT_EQ(answer.json["text"], text);
  int lines = 0;
  for (const Json& section : answer.json["sections"]) {
    for (const Json& key : section["values"]) {
      if (key["source"] != "file") continue;
      if (key["key"] == "id") lines += key["line"] == 2 ? 1 : 100;
      if (key["key"] == "pitch_mm") lines += key["line"] == 5 && section["name"] == "profile.body" ? 1 : 100;
    }
  }
  EXPECT_EQ(lines, 2);
}

TEST_F(TechnicianRoutes, AConfigurationIsCheckedByItsLine) {
  const auto check = [&](const std::string& text) {
    return console.Ask("POST", "/api/technician/parameters/check", {{"text", text}}).json;
  };
  EXPECT_EQ(check("[ring]\nbus = \"sim\"\n")["ok"], true);
  const Json wrong = check("[ring]\nbus = \"sim\"\nradius_mm = -3\n");
  EXPECT_EQ(wrong["ok"], false);
  EXPECT_EQ(wrong["error"]["line"], 3);
  EXPECT_EQ(console.Ask("POST", "/api/technician/parameters/check").field, "text");
}

TEST_F(TechnicianRoutes, RecordingsAreListedInspectedAndRecovered) {
  const std::vector<std::byte> whole = test::BeltRecording();
  console.store.AddRecorded("belt", whole);
  // The end is torn off, as a power cut does it.
  console.store.AddRecorded("belt",
                            {whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(9 * whole.size() / 10)});
  console.store.AddRecorded("belt", {});
  const auto listed = console.Ask("GET", "/api/technician/recordings");
  ASSERT_EQ(listed.json["recordings"].size(), 3U);
  EXPECT_EQ(listed.json["recordings"][0]["state"], "none");
  EXPECT_EQ(listed.json["recordings"][2]["state"], "kept");
  EXPECT_FALSE(listed.json.dump().find("K-1") != std::string::npos);
  const auto inspected = console.Ask("POST", "/api/technician/recordings/S-1/inspect");
  ASSERT_EQ(inspected.json["state"], "done") << inspected.json;
  EXPECT_EQ(inspected.json["result"]["finished"], true);
  EXPECT_EQ(inspected.json["result"]["levels"], ParseRecording(whole, "belt").value().scan.levels.size());
  const auto recovered = console.Ask("POST", "/api/technician/recordings/S-2/recover");
  ASSERT_EQ(recovered.json["state"], "done") << recovered.json;
  EXPECT_EQ(recovered.json["result"]["was_finished"], false);
  const std::string id = recovered.json["result"]["recovered"]["id"];
  EXPECT_TRUE(ParseRecording(console.store.ReadArtefact(id).value(), "recovered").value().report.recovered);
  EXPECT_EQ(console.Ask("POST", "/api/technician/recordings/S-3/inspect").status, 409);
  EXPECT_EQ(console.Ask("POST", "/api/technician/recordings/S-9/inspect").status, 404);
}

TEST_F(TechnicianRoutes, TheInterlockIsToldLineByLine) {
  EXPECT_EQ(console.Ask("GET", "/api/technician/interlock").status, 503);
  StatusMessage said;
  console.booth.said = said;
  const auto unknown = console.Ask("GET", "/api/technician/interlock");
  ASSERT_EQ(unknown.status, 200);
  EXPECT_EQ(unknown.json["lines"].size(), 18U);  // twelve in, seven out less the watchdog's pulses
  EXPECT_TRUE(unknown.json["lines"][0]["level"].is_null());
  SafetyLines lines;
  lines.input.fill(true);
  lines.input[static_cast<std::size_t>(InterlockInput::kDoor)] = false;
  said.scanner.lines = lines;
  console.booth.said = said;
  const auto open = console.Ask("GET", "/api/technician/interlock");
  EXPECT_EQ(open.json["chain_closed"], false);
  EXPECT_EQ(open.json["lines"][2]["name"], "door");
  EXPECT_EQ(open.json["lines"][2]["level"], false);
  EXPECT_EQ(open.json["lines"][2]["stops"], true);
}

}  // namespace
}  // namespace annulus
