/// What a scan cares for browsers and sessions: rows N1, N8 and U1 of the fault matrix, on the whole console.
#include <gmock/gmock.h>

#include "tests/console_whole/whole_station.h"
#include "tests/station_http/http_fixture.h"

namespace annulus::test {
namespace {

using std::chrono::minutes;
using std::chrono::seconds;

/// The levels that a booth has taken, by name.
std::vector<Boothd::LevelName> Names(const Boothd& booth) {
  std::vector<Boothd::LevelName> names;
  for (const auto& [name, time] : booth.Taken()) names.push_back(name);
  return names;
}

/// The scan ended as planned, and the store gives back every level of it.
void ExpectWhole(WholeStation& station, const StartedScan& scan) {
  const ScanRow row = station.WaitTakenIn(scan);
  const ScannerStatus status = station.booth().status();
  ASSERT_TRUE(status.scan);
  ASSERT_TRUE(status.scan->status) << status.scan->status.error().Text();
  EXPECT_TRUE(status.scan->complete);
  EXPECT_EQ(row.customer_id, scan.customer_id);
  EXPECT_EQ(row.consent_id, scan.consent_id);
  EXPECT_EQ(station.Recorded(row.id), Names(station.booth()));
}

TEST(ConsoleRows, N1_AScanWhoseBrowserIsGoneEndsAndIsInTheStore) {
  WholeStation station;
  StartedScan scan;
  {
    ConsoleBrowser browser = station.Browser();
    ASSERT_EQ(browser.LogIn("anna").status, 200);
    const LiveListener live(browser.OpenLive());
    scan = station.StartScan(browser, "short");
  }  // the browser is gone, without a goodbye
  EXPECT_EQ(station.booth().status().state, ScanState::kScanning);
  ExpectWhole(station, scan);
}

TEST(ConsoleRows, N1_AnotherSessionSeesTheScanOfAGoneBrowserAndStopsIt) {
  WholeStation station;
  StartedScan scan;
  {
    ConsoleBrowser browser = station.Browser();
    ASSERT_EQ(browser.LogIn("anna").status, 200);
    const LiveListener live(browser.OpenLive());
    scan = station.StartScan(browser, "long");
  }
  const std::size_t when_gone = station.booth().Taken().size();
  ConsoleBrowser other = station.Browser();
  ASSERT_EQ(other.LogIn("boris").status, 200);
  station.booth().Wait("more levels",
                       [&](const ScannerStatus&) { return station.booth().Taken().size() > when_gone + 5; });
  EXPECT_EQ(other.Get("/api/booth").json.at("status").at("state"), "SCANNING");
  EXPECT_EQ(other.Post("/api/stop").status, 200);
  const ScanRow row = station.WaitTakenIn(scan);
  const ScannerStatus status = station.booth().status();
  ASSERT_TRUE(status.scan);
  EXPECT_FALSE(status.scan->complete);
  EXPECT_EQ(row.customer_id, scan.customer_id);
  EXPECT_EQ(station.Recorded(row.id), Names(station.booth())) << "what was taken is kept";
}

TEST(ConsoleRows, U1_ACustomerWhoIsRenamedInMidScanIsStillTheOneWhoWasArmed) {
  WholeStation station;
  ConsoleBrowser browser = station.Browser();
  ASSERT_EQ(browser.LogIn("anna").status, 200);
  const StartedScan scan = station.StartScan(browser, "short");
  ConsoleBrowser other = station.Browser();
  ASSERT_EQ(other.LogIn("boris").status, 200);
  EXPECT_EQ(other.Post("/api/customers/" + scan.customer_id, {{"name", "Somebody else"}}).status, 200);
  EXPECT_EQ(other.Post("/api/customers", {{"name", "Hanako"}}).status, 200) << "and another of the old name";
  ExpectWhole(station, scan);
}

TEST(ConsoleRows, N8_AScanWhoseSessionExpiresEndsAndTheSessionOrdersNothingMore) {
  WholeStation station;
  ConsoleBrowser browser = station.Browser();
  ASSERT_EQ(browser.LogIn("anna").status, 200);
  LiveListener live(browser.OpenLive());
  const StartedScan scan = station.StartScan(browser, "short");
  station.clock.PutForward(minutes(5) + seconds(1));  // docs/security.md: five minutes without use, at the booth
  station.console().Tick();
  EXPECT_EQ(station.booth().status().state, ScanState::kScanning);
  const auto told = live.WaitFor("session_ended");
  ASSERT_FALSE(told.is_null());
  EXPECT_EQ(told.at("reason"), "not used for too long");
  EXPECT_EQ(live.WaitForEnd(), 1008);
  for (const char* order : {"/api/booth/home", "/api/booth/cancel", "/api/booth/acknowledge"}) {
    EXPECT_EQ(browser.Post(order).status, 401) << order;
  }
  EXPECT_EQ(browser.Post("/api/booth/start", {{"version", station.booth().status().version}}).status, 401);
  EXPECT_EQ(browser.Get("/api/customers").status, 401);
  ExpectWhole(station, scan);
}

TEST(ConsoleRows, N8_AnExpiredSessionMayStillStop) {
  WholeStation station;
  ConsoleBrowser browser = station.Browser();
  ASSERT_EQ(browser.LogIn("anna").status, 200);
  const StartedScan scan = station.StartScan(browser, "long");
  station.clock.PutForward(minutes(5) + seconds(1));
  station.console().Tick();
  EXPECT_EQ(browser.Post("/api/stop").status, 200);
  const ScanRow row = station.WaitTakenIn(scan);
  EXPECT_FALSE(station.booth().status().scan->complete);
  EXPECT_EQ(station.Recorded(row.id), Names(station.booth()));
}

}  // namespace
}  // namespace annulus::test
