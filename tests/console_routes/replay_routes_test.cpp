#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <sstream>

#include "acquisition/recording.h"
#include "firmware_iface/usb_frame_codec.h"
#include "tests/console_routes/recorded_scan.h"
#include "tests/console_routes/route_console.h"

namespace annulus {
namespace {

using Json = nlohmann::json;

class ReplayRoutes : public testing::Test {
 protected:
  void SetUp() override {
    const auto opened = console.Ask("POST", "/api/replay/open", {{"scan", scan}});
    ASSERT_EQ(opened.status, 200) << opened.json;
    summary = opened.json;
    at = "/api/replay/" + summary["replay_id"].get<std::string>();
  }

  test::RouteConsole console;
  std::string scan = console.store.AddRecorded("belt", test::BeltRecording());
  Json summary;
  std::string at;
};

/// The ranges of `annulus export`, by level and sensor; nan where it says nan.
std::vector<std::vector<double>> ExportedRanges(std::size_t levels, std::size_t sensors) {
  const std::string recording = test::BinaryFolder() + "/console-routes-export.mcap";
  const std::string table = test::BinaryFolder() + "/console-routes-export.csv";
  PosixStorage storage;
  EXPECT_TRUE(WriteFileAtomically(storage, recording, std::span<const std::byte>(test::BeltRecording())));
  const std::vector<const char*> arguments{"annulus", "export", recording.c_str(), "--out", table.c_str()};
  testing::internal::CaptureStdout();
  EXPECT_EQ(RunCommandLine(static_cast<int>(arguments.size()), arguments.data(), {}), 0);
  testing::internal::GetCapturedStdout();
  std::istringstream lines(ReadTextFile(storage, table).value());
  std::vector<double> all;
  std::string line;
  std::size_t column = 0;
  while (std::getline(lines, line)) {
    if (line.empty() || line.front() == '#') continue;
    std::vector<std::string> cells;
    std::istringstream row(line);
    for (std::string cell; std::getline(row, cell, ',');) cells.push_back(cell);
    if (line.starts_with("level")) {
      column = static_cast<std::size_t>(std::find(cells.begin(), cells.end(), "range_mm") - cells.begin());
      continue;
    }
    all.push_back(cells.at(column) == "nan" ? std::nan("") : std::stod(cells.at(column)));
  }
  EXPECT_EQ(all.size(), levels * sensors);
  std::vector<std::vector<double>> ranges;
  for (std::size_t k = 0; k + sensors <= all.size(); k += sensors) {
    ranges.emplace_back(all.begin() + static_cast<std::ptrdiff_t>(k),
                        all.begin() + static_cast<std::ptrdiff_t>(k + sensors));
  }
  return ranges;
}

TEST_F(ReplayRoutes, TheMapIsTheExportedTable) {
  const auto answer = console.Ask("GET", at + "/map");
  ASSERT_EQ(answer.status, 200);
  const std::string& bytes = answer.response.body;
  std::uint32_t size[2] = {};
  ASSERT_GE(bytes.size(), sizeof size);
  std::memcpy(size, bytes.data(), sizeof size);
  EXPECT_EQ(size[0], summary["levels"]);
  EXPECT_EQ(size[1], 180U);
  ASSERT_EQ(bytes.size(), 8 + std::size_t{size[0]} * (4 * std::size_t{size[1]} + 4 + 8));
  const auto exported = ExportedRanges(size[0], size[1]);
  ASSERT_EQ(exported.size(), size[0]);
  for (std::size_t level = 0; level < size[0]; ++level) {
    for (std::size_t sensor = 0; sensor < size[1]; ++sensor) {
      float range = 0.0F;
      std::memcpy(&range, bytes.data() + 8 + 4 * (level * size[1] + sensor), 4);
      const double wanted = exported[level][sensor];
      if (std::isnan(wanted)) {
        EXPECT_TRUE(std::isnan(range));
      } else {
        EXPECT_EQ(range, static_cast<float>(wanted)) << level << " " << sensor;
      }
    }
  }
}

TEST_F(ReplayRoutes, TheBytesOfALevelHoldItsReadings) {
  // Put together by the wire's own codec, from what the page is given alone.
  std::map<std::string, UsbFrameAssembler> ports;
  std::set<std::pair<std::uint32_t, std::uint32_t>> seen;
  const auto levels = summary["levels"].get<std::size_t>();
  std::size_t compared = 0;
  for (std::size_t n = 0; n < levels; ++n) {
    const auto answer = console.Ask("GET", at + "/level/" + std::to_string(n));
    ASSERT_EQ(answer.status, 200) << answer.json;
    EXPECT_EQ(answer.json["n"], n);
    for (const Json& frame : answer.json["frames"]) {
      if (!frame["bus"].get<std::string>().starts_with("usb") || frame["direction"] != "in") continue;
      if (frame["meaning"].get<std::string>().find("level of board") == std::string::npos) continue;
      std::vector<std::byte> bytes;
      const std::string hex = frame["bytes_hex"];
      for (std::size_t k = 0; k + 1 < hex.size(); k += 2) {
        bytes.push_back(static_cast<std::byte>(std::stoul(hex.substr(k, 2), nullptr, 16)));
      }
      for (const LevelFrame& level : ports[frame["bus"]].Push(bytes)) {
        EXPECT_TRUE(seen.emplace(level.board_serial, level.sequence).second) << "a frame is told twice";
        const std::string meaning = frame["meaning"];
        EXPECT_NE(meaning.find("SYNC count " + std::to_string(level.sequence)), std::string::npos);
        ++compared;
      }
    }
  }
  EXPECT_GT(compared, 12 * (levels - 2));  // twelve boards; the run-up to the first level is none of it
  const Scan recorded = ParseRecording(test::BeltRecording(), "belt").value().scan;
  const auto first = console.Ask("GET", at + "/level/3");
  for (std::size_t sensor = 0; sensor < 180; ++sensor) {
    const double range = recorded.levels[3].readings[sensor].range_mm;
    const Json& told = first.json["range_mm"][sensor];
    EXPECT_TRUE(std::isfinite(range) ? told == range : told.is_null());
  }
}

TEST_F(ReplayRoutes, LevelsThatAreNotThereAreRefused) {
  EXPECT_EQ(console.Ask("GET", at + "/level/1000000").status, 404);
  EXPECT_EQ(console.Ask("GET", at + "/level/-1").status, 400);
  EXPECT_EQ(console.Ask("GET", at + "/level/two").field, "n");
  EXPECT_EQ(console.Ask("GET", "/api/replay/R-99/map").status, 404);
  EXPECT_EQ(console.Ask("POST", "/api/replay/open", {{"scan", "S-99"}}).status, 404);
  EXPECT_EQ(console.Ask("POST", "/api/replay/open", {{"path", "x"}}).field, "path");
}

TEST_F(ReplayRoutes, WithoutFaultsTheReplayIsIdentical) {
  const auto answer = console.Ask("POST", at + "/run");
  ASSERT_EQ(answer.json["state"], "done") << answer.json;
  EXPECT_EQ(answer.json["result"]["identical"], true);
  EXPECT_EQ(answer.json["result"]["recorded_levels"], summary["levels"]);
}

TEST_F(ReplayRoutes, WithFaultsItSaysWhereItDiffers) {
  const Json plan = {
      {"format", "annulus fault plan"},
      {"version", 1},
      {"seed", 3},
      {"faults",
       {{{"at", {{"level", 2}}}, {"for_s", 1.0}, {"target", "usb"}, {"kind", "damage"}, {"args", {{"share", 0.5}}}}}}};
  const auto answer = console.Ask("POST", at + "/run", {{"faults", plan}});
  ASSERT_EQ(answer.json["state"], "done") << answer.json;
  EXPECT_EQ(answer.json["result"]["identical"], false);
  EXPECT_FALSE(answer.json["result"]["first_difference"].is_null());
  EXPECT_FALSE(answer.json["result"]["faults"].empty());
  EXPECT_EQ(console.Ask("POST", at + "/run", {{"faults", {{"format", "no plan"}}}}).field, "faults");
  EXPECT_EQ(console.Ask("POST", at + "/run", {{"from", 5}, {"to", 4}}).field, "to");
  EXPECT_EQ(console.Ask("POST", at + "/run", {{"from", -1}}).field, "from");
}

TEST_F(ReplayRoutes, TwoFitsAreCompared) {
  const auto fit = [&](const Json& options) {
    const auto answer = console.Ask("POST", at + "/fit", {{"options", options}});
    EXPECT_EQ(answer.json["state"], "done") << answer.json;
    return answer.json["result"];
  };
  const Json adaptive = fit({{"method", "adaptive"}});
  const Json uniform = fit({{"method", "uniform"}, {"theta_knots", 24}, {"z_knots", 8}});
  EXPECT_NE(adaptive["coefficients"], uniform["coefficients"]);
  EXPECT_GT(adaptive["residuals_png"].get<std::string>().size(), 100U);
  const auto same = console.Ask("POST", at + "/compare", {{"a", adaptive["model_id"]}, {"b", adaptive["model_id"]}});
  ASSERT_EQ(same.status, 200) << same.json;
  EXPECT_EQ(same.json["rms_mm"], 0.0);
  const auto other = console.Ask("POST", at + "/compare", {{"a", adaptive["model_id"]}, {"b", uniform["model_id"]}});
  EXPECT_GT(other.json["rms_mm"].get<double>(), 0.0);
  EXPECT_LT(other.json["rms_mm"].get<double>(), 2.0);  // of a smooth waist
  EXPECT_GE(std::abs(other.json["largest_mm"].get<double>()), other.json["p95_mm"].get<double>());
  EXPECT_EQ(console.Ask("POST", at + "/compare", {{"a", "M-9"}, {"b", "M-9"}}).status, 404);
  for (const auto& [options, field] :
       std::vector<std::pair<Json, std::string>>{{{{"method", "best"}}, "method"},
                                                 {{{"method", "uniform"}, {"theta_knots", -1}}, "theta_knots"},
                                                 {{{"method", "uniform"}, {"z_knots", 401}}, "z_knots"},
                                                 {{{"method", "adaptive"}, {"z_knots", 10}}, "z_knots"},
                                                 {{{"knots", 3}}, "knots"}}) {
    const auto answer = console.Ask("POST", at + "/fit", {{"options", options}});
    EXPECT_EQ(answer.status, 400) << options;
    EXPECT_EQ(answer.field, field) << options;
  }
}

TEST_F(ReplayRoutes, ClosedItIsGone) {
  EXPECT_EQ(console.Ask("POST", at + "/close").status, 200);
  EXPECT_EQ(console.Ask("GET", at + "/map").status, 404);
  EXPECT_EQ(console.Ask("POST", at + "/close").status, 200);
}

}  // namespace
}  // namespace annulus
