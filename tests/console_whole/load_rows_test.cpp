/// Stuck clients and a flood of bad requests beside a scan: rows N4 and N5 of the fault matrix, on the whole console.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <cstdio>

#include "tests/console_whole/bad_clients.h"
#include "tests/console_whole/whole_station.h"
#include "tests/station_http/http_fixture.h"

namespace annulus::test {
namespace {

using std::chrono::nanoseconds;
using std::chrono::seconds;
using LevelName = Boothd::LevelName;

constexpr std::size_t kStuck = 20;
constexpr double kBadPerSecond = 1000.0;

double Milliseconds(nanoseconds time) { return std::chrono::duration<double, std::milli>(time).count(); }

/// The value below which this share of them lies; 0 of none.
double Quantile(std::vector<double> values, double share) {
  if (values.empty()) return 0.0;
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
}

/// What came of a scan.
struct Outcome {
  std::string busy;  ///< Why the booth stopped, if this machine was too busy; "": it did not.
  bool complete = false;
  std::vector<LevelName> taken;     ///< By the booth.
  std::vector<LevelName> recorded;  ///< In the store.
  std::vector<LevelName> heard;     ///< By a browser that reads.
  std::vector<double> tick_ms;
  std::vector<double> latency_ms;  ///< From taken to heard.
  std::string scheduling_note;
  double bad_per_second = 0.0;
  std::string bad;
  std::size_t stuck_left = kStuck;  ///< Still served a minute after the scan.

  [[nodiscard]] std::string Text() const {
    return fmt::format(
        "{} levels taken, {} recorded, {} heard after p50 {:.1f}, p99 {:.1f} ms; ticks p50 {:.2f}, p99.9 {:.2f}, "
        "longest {:.2f} ms{}{}",
        taken.size(), recorded.size(), heard.size(), Quantile(latency_ms, 0.5), Quantile(latency_ms, 0.99),
        Quantile(tick_ms, 0.5), Quantile(tick_ms, 0.999), Quantile(tick_ms, 1.0), bad.empty() ? "" : "; ", bad);
  }
};

void NoteLevels(const Boothd& booth, const LiveListener& live, Outcome& outcome) {
  const auto taken = booth.Taken();
  for (const auto& [name, time] : taken) outcome.taken.push_back(name);
  for (const LiveListener::Heard& one : live.All()) {
    if (one.message.at("type") != "level") continue;
    const LevelName name(one.message.at("sweep"), one.message.at("level"));
    outcome.heard.push_back(name);
    outcome.latency_ms.push_back(Milliseconds(one.time - taken.at(name)));
  }
}

/// The recording of an interrupted scan, too.
std::vector<LevelName> RecordedOf(WholeStation& station, const std::string& customer_id) {
  std::vector<ScanRow> rows;
  Eventually(
      [&] {
        rows = station.console().store().ScansOf(customer_id).value_or(rows);
        return !rows.empty();
      },
      seconds(60));
  return rows.empty() ? std::vector<LevelName>() : station.Recorded(rows.front().id);
}

enum class Network { kQuiet, kHostile };

Outcome TakeScan(Network network) {
  Outcome outcome;
  WholeStation station(Pace::kRealTime);
  ConsoleBrowser browser = station.Browser();
  EXPECT_EQ(browser.LogIn("anna").status, 200);
  const LiveListener live(browser.OpenLive());
  std::unique_ptr<StuckClients> stuck;
  std::unique_ptr<BadClients> bad;
  if (network == Network::kHostile) {
    stuck = std::make_unique<StuckClients>(browser, kStuck);
    EXPECT_EQ(stuck->StillServed(), kStuck);
    bad = std::make_unique<BadClients>(station.target());
  }
  StartedScan scan;
  try {
    scan = station.StartScan(browser, "long");
    static_cast<void>(station.booth().TakeTicks());  // of before
    station.booth().Wait("end of the scan", IsIdle);
    outcome.complete = station.booth().status().scan && station.booth().status().scan->complete;
  } catch (const TooBusy& machine) {
    outcome.busy = machine.what();
  }
  for (const nanoseconds tick : station.booth().TakeTicks()) outcome.tick_ms.push_back(Milliseconds(tick));
  outcome.scheduling_note = station.booth().scheduling_note();
  if (bad != nullptr) {
    outcome.bad_per_second = bad->PerSecond();
    outcome.bad = bad->Text();
    EXPECT_EQ(browser.Get("/api/booth").status, 200) << "who behaves is served";
    if (outcome.busy.empty()) {
      Eventually([&] { return stuck->StillServed() == 0; }, seconds(60));
      outcome.stuck_left = stuck->StillServed();
    }
  }
  bad.reset();
  if (!scan.customer_id.empty()) outcome.recorded = RecordedOf(station, scan.customer_id);
  NoteLevels(station.booth(), live, outcome);
  return outcome;
}

void Judge(const Outcome& quiet, const Outcome& hostile) {
  EXPECT_TRUE(hostile.complete) << "every level of the plan";
  EXPECT_EQ(hostile.taken.size(), quiet.taken.size()) << "the plan is the same";
  EXPECT_EQ(hostile.stuck_left, 0U) << "whoever never reads is dropped";
  EXPECT_EQ(hostile.heard, hostile.taken) << "in order, at a browser that reads";
  if (hostile.scheduling_note.empty()) {
    EXPECT_LT(Quantile(hostile.tick_ms, 0.999), 12.0) << "the limit from which on a tick is called late";
  } else {
    std::printf("the ticks are not judged: %s\n", hostile.scheduling_note.c_str());
  }
  if (hostile.bad_per_second < kBadPerSecond) {
    GTEST_SKIP() << "this machine could only send " << hostile.bad_per_second << " bad requests/s";
  }
}

/// The same scan on a quiet network and on a hostile one. A booth that stops because this machine is too busy for real
/// time has still to record what it took; if it stops in every attempt on the hostile network and in none on the quiet
/// one, the network stopped it.
TEST(ConsoleRows, N4_N5_StuckClientsAndAFloodCostAScanNothing) {
  constexpr int kAttempts = 3;
  int stopped_quiet = 0;
  std::string busy;
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    const Outcome quiet = TakeScan(Network::kQuiet);
    const Outcome hostile = TakeScan(Network::kHostile);
    std::printf("quiet:   %s %s\nhostile: %s %s\n", quiet.Text().c_str(), quiet.busy.c_str(), hostile.Text().c_str(),
                hostile.busy.c_str());
    EXPECT_EQ(quiet.recorded, quiet.taken);
    EXPECT_EQ(hostile.recorded, hostile.taken) << "no level that was taken is lost, whyever the scan ended";
    if (quiet.busy.empty() && hostile.busy.empty()) return Judge(quiet, hostile);
    stopped_quiet += quiet.busy.empty() ? 0 : 1;
    busy = hostile.busy.empty() ? quiet.busy : hostile.busy;
  }
  ASSERT_GT(stopped_quiet, 0) << "only on the hostile network, every time: " << busy;
  GTEST_SKIP() << "too busy a machine for real time also on a quiet network: " << busy;
}

}  // namespace
}  // namespace annulus::test
